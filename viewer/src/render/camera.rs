//! Cameras: over a map, and around a place in space.

use geom::{Bounds, Vec2, Vec3};
use glam::{DMat4, DVec3, Mat4};

/// Looks at a map from above.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MapCamera {
    /// What lies in the middle, in metres.
    pub centre: Vec2,
    /// Metres to the pixel.
    pub scale: f64,
}

/// Nearest and farthest scale, metres to the pixel.
const SCALES: (f64, f64) = (0.01, 500.0);

impl MapCamera {
    /// Shows all of some ground on so many pixels.
    pub fn over(bounds: Bounds, pixels: [f32; 2]) -> Self {
        let size = bounds.size() * 1.04;
        let scale = (size.x / f64::from(pixels[0].max(1.0))).max(size.y / f64::from(pixels[1].max(1.0)));
        Self { centre: (bounds.min.metres() + bounds.max.metres()) / 2.0, scale: scale.clamp(SCALES.0, SCALES.1) }
    }

    /// The place under a pixel, counted from the upper left.
    pub fn place(&self, [x, y]: [f32; 2], [width, height]: [f32; 2]) -> Vec2 {
        let off = Vec2::new(f64::from(x - width / 2.0), f64::from(height / 2.0 - y));
        self.centre + off * self.scale
    }

    /// The pixel over a place.
    pub fn pixel(&self, place: Vec2, [width, height]: [f32; 2]) -> [f32; 2] {
        let off = (place - self.centre) / self.scale;
        [width / 2.0 + off.x as f32, height / 2.0 - off.y as f32]
    }

    /// Moves so that the ground follows the hand.
    pub fn drag(&mut self, [x, y]: [f32; 2]) {
        self.centre += Vec2::new(f64::from(-x), f64::from(y)) * self.scale;
    }

    /// Comes nearer by a factor, keeping what is under a pixel there.
    pub fn zoom(&mut self, factor: f64, at: [f32; 2], pixels: [f32; 2]) {
        let fixed = self.place(at, pixels);
        self.scale = (self.scale / factor).clamp(SCALES.0, SCALES.1);
        self.centre += fixed - self.place(at, pixels);
    }

    /// From metres around its centre to the clip space of so many pixels.
    pub fn to_clip(&self, [width, height]: [f32; 2]) -> Mat4 {
        let (x, y) = (2.0 / (f64::from(width) * self.scale), 2.0 / (f64::from(height) * self.scale));
        Mat4::from_scale(glam::Vec3::new(x as f32, y as f32, 0.0)) * Mat4::from_translation(glam::Vec3::ZERO)
    }
}

/// Looks at a place from around it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct OrbitCamera {
    /// What is looked at: metres east, north and up.
    pub target: Vec3,
    /// Metres from there.
    pub distance: f64,
    /// Degrees from north, clockwise, that it looks towards.
    pub heading: f64,
    /// Degrees below the horizon that it looks.
    pub pitch: f64,
}

/// How steep it may look.
const PITCHES: (f64, f64) = (2.0, 89.5);

/// The picture that a city is fitted into where no other is known.
const ROOM: [f64; 2] = [1500.0, 1000.0];

/// Share of it that is filled, one way or the other.
const FILLED: f64 = 0.94;

/// Steps of the fitting; after a few nothing changes any more.
const FITTINGS: usize = 24;

/// Half the height of what it sees, at distance 1.
const HALF_FIELD: f64 = 0.4142;

impl OrbitCamera {
    /// Shows all of some ground from the south-west.
    pub fn over(bounds: Bounds, height: f64) -> Self {
        Self::towards(bounds, height, (25.0, 42.0), ROOM)
    }

    /// Shows all of some ground in a picture of so many pixels, looking that way (heading and pitch).
    pub fn towards(bounds: Bounds, height: f64, (heading, pitch): (f64, f64), room: [f64; 2]) -> Self {
        let middle = (bounds.min.metres() + bounds.max.metres()) / 2.0;
        let distance = (bounds.size().length() * 0.95).max(50.0);
        let mut camera = Self { target: middle.extend(height), distance, heading, pitch };
        // What is near takes more room than what is far: the middle of the ground is not that of the picture.
        for _ in 0..FITTINGS {
            let (low, high) = camera.span(bounds, room);
            let (middle, most) = ((low + high) / 2.0, ((high - low) / 2.0).max_element());
            camera.pan([(-middle.x * room[0] / 2.0) as f32, (middle.y * room[1] / 2.0) as f32], room[1] as f32);
            camera.distance = (camera.distance * most / FILLED).max(50.0);
        }
        camera
    }

    /// Between which places of a picture some ground lies, from -1 to 1 each way.
    fn span(&self, bounds: Bounds, room: [f64; 2]) -> (Vec2, Vec2) {
        let (low, high) = (bounds.min.metres(), bounds.max.metres());
        let to_clip = self.to_clip(room.map(|side| side as f32));
        let corners = [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)].map(|corner| {
            let place = to_clip * (corner - self.target.truncate()).as_vec2().extend(0.0).extend(1.0);
            // What lies behind the eye is as far off as can be.
            Vec2::new(f64::from(place.x), f64::from(place.y)) / f64::from(place.w.max(1e-3))
        });
        corners.iter().fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(l, h), at| (l.min(*at), h.max(*at)))
    }

    /// The way it looks, of length 1.
    pub fn forward(&self) -> Vec3 {
        let (heading, pitch) = (self.heading.to_radians(), self.pitch.to_radians());
        Vec3::new(heading.sin() * pitch.cos(), heading.cos() * pitch.cos(), -pitch.sin())
    }

    /// Where it stands.
    pub fn eye(&self) -> Vec3 {
        self.target - self.forward() * self.distance
    }

    /// Turns around its target by pixels of a drag.
    pub fn turn(&mut self, [x, y]: [f32; 2]) {
        self.heading = (self.heading + f64::from(x) * 0.3).rem_euclid(360.0);
        self.pitch = (self.pitch + f64::from(y) * 0.3).clamp(PITCHES.0, PITCHES.1);
    }

    /// Moves along the ground by pixels of a drag.
    pub fn pan(&mut self, [x, y]: [f32; 2], height: f32) {
        let metres = self.distance * 2.0 * HALF_FIELD / f64::from(height.max(1.0));
        let ahead = Vec2::new(self.heading.to_radians().sin(), self.heading.to_radians().cos());
        let right = Vec2::new(ahead.y, -ahead.x);
        let way =
            right * f64::from(-x) * metres + ahead * f64::from(y) * metres / self.pitch.to_radians().sin().max(0.2);
        self.target += way.extend(0.0);
    }

    /// Comes nearer by a factor.
    pub fn zoom(&mut self, factor: f64) {
        self.distance = (self.distance / factor).clamp(5.0, 200_000.0);
    }

    /// Nearest and farthest that it sees, in metres.
    pub fn range(&self) -> (f64, f64) {
        ((self.distance * 0.02).max(0.5), self.distance * 8.0 + 3000.0)
    }

    /// From metres around its target to clip space.
    pub fn to_clip(&self, [width, height]: [f32; 2]) -> Mat4 {
        let (near, far) = self.range();
        let aspect = f64::from(width.max(1.0)) / f64::from(height.max(1.0));
        let eye = -self.forward() * self.distance;
        (perspective(aspect, near, far) * looking(eye, self.forward(), DVec3::Z)).as_mat4()
    }

    /// The pixels that both ends of a line in space are seen at, as far as it lies before the eye; `None` where it does not.
    pub fn pixels_of(&self, ends: [Vec3; 2], [width, height]: [f32; 2]) -> Option<[[f32; 2]; 2]> {
        let to_clip = self.to_clip([width, height]);
        let (near, _) = self.range();
        let [mut a, mut b] = ends.map(|end| to_clip * (end - self.target).as_vec3().extend(1.0));
        let near = near as f32;
        if a.w < near && b.w < near {
            return None;
        }
        if a.w < near {
            a += (b - a) * ((near - a.w) / (b.w - a.w));
        } else if b.w < near {
            b += (a - b) * ((near - b.w) / (a.w - b.w));
        }
        Some([a, b].map(|at| [(at.x / at.w * 0.5 + 0.5) * width, (0.5 - at.y / at.w * 0.5) * height]))
    }

    /// The ground under a pixel, where it lies at the height of the target; far off where the pixel shows the sky.
    pub fn ground(&self, pixel: [f32; 2], pixels: [f32; 2]) -> Vec2 {
        let (from, way) = self.ray(pixel, pixels);
        let farthest = self.distance * 20.0;
        let along = if way.z < -1e-6 { ((from.z - self.target.z) / -way.z).min(farthest) } else { farthest };
        (from + way * along).truncate()
    }

    /// The ray through a pixel: where it starts and its way.
    pub fn ray(&self, [x, y]: [f32; 2], [width, height]: [f32; 2]) -> (Vec3, Vec3) {
        let (forward, aspect) = (self.forward(), f64::from(width) / f64::from(height.max(1.0)));
        let right = forward.cross(DVec3::Z).normalize();
        let up = right.cross(forward);
        let across = (f64::from(x) / f64::from(width) * 2.0 - 1.0) * HALF_FIELD * aspect;
        let along = (1.0 - f64::from(y) / f64::from(height) * 2.0) * HALF_FIELD;
        (self.eye(), (forward + right * across + up * along).normalize())
    }
}

/// A perspective with depths from 0 (near) to 1.
fn perspective(aspect: f64, near: f64, far: f64) -> DMat4 {
    let (x, y) = (1.0 / (HALF_FIELD * aspect), 1.0 / HALF_FIELD);
    let depth = far / (near - far);
    DMat4::from_cols_array(&[x, 0.0, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, 0.0, depth, -1.0, 0.0, 0.0, near * depth, 0.0])
}

/// From the world to what an eye sees, x right, y up, looking along -z.
pub(super) fn looking(eye: DVec3, forward: DVec3, up: DVec3) -> DMat4 {
    let right = forward.cross(up).normalize_or(DVec3::X);
    let up = right.cross(forward);
    let turn = DMat4::from_cols(right.extend(0.0), up.extend(0.0), (-forward).extend(0.0), DVec3::ZERO.extend(1.0))
        .transpose();
    turn * DMat4::from_translation(-eye)
}

/// A box as wide as `radius` each way, seen along -z: depths from 0 to 1.
pub(super) fn orthographic(radius: f64, depth: f64) -> DMat4 {
    let (side, deep) = (1.0 / radius, 1.0 / depth);
    DMat4::from_cols_array(&[side, 0.0, 0.0, 0.0, 0.0, side, 0.0, 0.0, 0.0, 0.0, -deep / 2.0, 0.0, 0.0, 0.0, 0.5, 1.0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use geom::Point;

    const PIXELS: [f32; 2] = [800.0, 600.0];

    #[test]
    fn a_map_zooms_around_what_is_under_the_pointer() {
        let mut camera = MapCamera { centre: Vec2::new(100.0, 50.0), scale: 2.0 };
        let under = camera.place([13.0, 400.0], PIXELS);
        camera.zoom(1.7, [13.0, 400.0], PIXELS);
        assert!(camera.place([13.0, 400.0], PIXELS).distance(under) < 1e-3);
        let [x, y] = camera.pixel(under, PIXELS);
        assert!((x - 13.0).abs() < 0.01 && (y - 400.0).abs() < 0.01);
    }

    #[test]
    fn all_of_the_ground_is_shown() {
        let bounds = Bounds { min: Point::new(0, 0), max: Point::new(1024 * 3000, 1024 * 500) };
        let camera = MapCamera::over(bounds, PIXELS);
        for corner in [bounds.min, bounds.max] {
            let [x, y] = camera.pixel(corner.metres(), PIXELS);
            assert!((0.0..=PIXELS[0]).contains(&x) && (0.0..=PIXELS[1]).contains(&y));
        }
    }

    #[test]
    fn all_of_the_ground_is_shown_in_space_and_fills_the_picture() {
        for (width, height) in [(3000, 500), (500, 3000), (2000, 2000), (13_000, 22_900), (40, 30)] {
            let bounds = Bounds { min: Point::new(-1024 * 200, 77), max: Point::new(1024 * width, 1024 * height) };
            for room in [ROOM, [400.0, 700.0], [3000.0, 200.0]] {
                let camera = OrbitCamera::towards(bounds, 12.0, (25.0, 42.0), room);
                let (low, high) = camera.span(bounds, room);
                assert!(low.min_element() > -1.0 && high.max_element() < 1.0, "{width} {height}: {low} {high}");
                assert!(((high - low) / 2.0).max_element() > 0.85, "{width} {height}: {low} {high}");
                assert!(((low + high) / 2.0).abs().max_element() < 0.1, "it lies in the middle: {low} {high}");
            }
        }
    }

    #[test]
    fn the_ray_through_the_middle_meets_the_target() {
        let camera = OrbitCamera { target: Vec3::new(10.0, 20.0, 5.0), distance: 300.0, heading: 77.0, pitch: 33.0 };
        let (from, way) = camera.ray([400.0, 300.0], PIXELS);
        assert!((from + way * 300.0).distance(camera.target) < 1e-6);
        let clip = camera.to_clip(PIXELS) * glam::Vec4::new(0.0, 0.0, 0.0, 1.0);
        assert!((clip.x / clip.w).abs() < 1e-4 && (clip.y / clip.w).abs() < 1e-4);
        assert!((0.0..1.0).contains(&(clip.z / clip.w)));
    }

    #[test]
    fn lines_in_space_are_seen_where_rays_go_and_are_cut_off_at_the_eye() {
        let camera = OrbitCamera { target: Vec3::new(900.0, -40.0, 7.0), distance: 500.0, heading: 200.0, pitch: 50.0 };
        let through = |pixel: [f32; 2], far: f64| {
            let (from, way) = camera.ray(pixel, PIXELS);
            from + way * far
        };
        let ends = [[130.0, 470.0], [700.0, 20.0]];
        let seen = camera.pixels_of([through(ends[0], 350.0), through(ends[1], 800.0)], PIXELS).unwrap();
        for (seen, end) in seen.iter().zip(ends) {
            assert!((seen[0] - end[0]).abs() < 0.1 && (seen[1] - end[1]).abs() < 0.1, "{seen:?} {end:?}");
        }
        let behind = through([400.0, 300.0], -50.0);
        let cut = camera.pixels_of([behind, through(ends[0], 350.0)], PIXELS).unwrap();
        assert!((cut[1][0] - 130.0).abs() < 0.1 && cut[0].iter().all(|pixel| pixel.is_finite()), "{cut:?}");
        assert_eq!(camera.pixels_of([behind, through(ends[0], -9.0)], PIXELS), None);
    }

    #[test]
    fn rays_and_clip_space_agree() {
        let camera = OrbitCamera { target: Vec3::ZERO, distance: 500.0, heading: 200.0, pitch: 50.0 };
        let (from, way) = camera.ray([130.0, 470.0], PIXELS);
        let place = (from + way * 350.0).as_vec3();
        let clip = camera.to_clip(PIXELS) * place.extend(1.0);
        let at = [(clip.x / clip.w * 0.5 + 0.5) * PIXELS[0], (0.5 - clip.y / clip.w * 0.5) * PIXELS[1]];
        assert!((at[0] - 130.0).abs() < 0.1 && (at[1] - 470.0).abs() < 0.1, "{at:?}");
    }
}
