// Shared by all passes. Metres, x east, y north, z up, around the view's own origin.
struct View {
    to_clip: mat4x4<f32>,
    to_sun: mat4x4<f32>,
    // Direction to the sun; w: 1 where there are shadows.
    sun: vec4<f32>,
    // Pixels of the target; near plane and far plane, of a map metres to the pixel and nothing.
    screen: vec4<f32>,
    // Least corner and size in metres of the site, seen from the view's origin.
    site: vec4<f32>,
    // Opacity of the overlay, strength of silhouettes, whether water and parks are told from land.
    strengths: vec4<f32>,
};
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var linear_sampler: sampler;
@group(0) @binding(2) var shadow_sampler: sampler_comparison;
@group(0) @binding(3) var overlay_map: texture_2d<f32>;
@group(0) @binding(4) var shadow_map: texture_depth_2d;

fn overlay_colour(value: f32) -> vec3<f32> {
    // From dark blue over teal to yellow: even steps in lightness.
    let t = clamp(value, 0.0, 1.0);
    let a = vec3<f32>(0.18, 0.13, 0.36);
    let b = vec3<f32>(0.13, 0.50, 0.55);
    let c = vec3<f32>(0.98, 0.88, 0.30);
    return select(mix(b, c, t * 2.0 - 1.0), mix(a, b, t * 2.0), t < 0.5);
}

// What the overlay shows at a place, and how strongly.
fn overlay_at(place: vec2<f32>) -> vec4<f32> {
    let at = (place - view.site.xy) / view.site.zw;
    let value = textureSampleLevel(overlay_map, linear_sampler, vec2<f32>(at.x, 1.0 - at.y), 0.0).r;
    let inside = all(at >= vec2<f32>(0.0)) && all(at <= vec2<f32>(1.0));
    return vec4<f32>(overlay_colour(value), select(0.0, view.strengths.x, inside));
}

struct SolidIn {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec4<f32>,
    @location(2) colour: vec4<f32>,
    @location(3) corner: vec2<f32>,
};
struct SolidOut {
    @builtin(position) clip: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) colour: vec3<f32>,
    @location(2) place: vec3<f32>,
};

@vertex
fn solid_vertex(in: SolidIn) -> SolidOut {
    var out: SolidOut;
    let place = in.position + vec3<f32>(in.corner, 0.0);
    out.clip = view.to_clip * vec4<f32>(place, 1.0);
    out.normal = in.normal.xyz;
    out.colour = in.colour.rgb;
    out.place = place;
    return out;
}

@vertex
fn shadow_vertex(in: SolidIn) -> @builtin(position) vec4<f32> {
    return view.to_sun * vec4<f32>(in.position + vec3<f32>(in.corner, 0.0), 1.0);
}

fn lit(place: vec3<f32>, normal: vec3<f32>) -> f32 {
    if (view.sun.w < 0.5) {
        return 1.0;
    }
    let at = view.to_sun * vec4<f32>(place + normal * 0.8, 1.0);
    let uv = vec2<f32>(at.x * 0.5 + 0.5, 0.5 - at.y * 0.5);
    let texel = 1.0 / f32(textureDimensions(shadow_map).x);
    var sum = 0.0;
    for (var i = 0; i < 4; i++) {
        let off = vec2<f32>(f32(i & 1) - 0.5, f32(i >> 1) - 0.5) * texel;
        sum += textureSampleCompareLevel(shadow_map, shadow_sampler, uv + off, at.z - 0.0006);
    }
    // Far from what is looked at nothing is known of shadows.
    let known = all(uv > vec2<f32>(0.0)) && all(uv < vec2<f32>(1.0)) && at.z < 1.0;
    return select(1.0, sum * 0.25, known);
}

@fragment
fn solid_fragment(in: SolidOut) -> @location(0) vec4<f32> {
    let normal = normalize(in.normal);
    let sun = max(dot(normal, view.sun.xyz), 0.0) * lit(in.place, normal);
    // Sky from above, light thrown back from the ground.
    let sky = mix(vec3<f32>(0.30, 0.28, 0.25), vec3<f32>(0.52, 0.56, 0.62), normal.z * 0.5 + 0.5);
    let over = overlay_at(in.place.xy);
    let colour = mix(in.colour, over.rgb, over.a);
    return vec4<f32>(colour * (sky + sun * vec3<f32>(0.62, 0.58, 0.50)), 1.0);
}

struct FlatIn {
    @location(0) position: vec2<f32>,
    @location(1) colour: vec4<f32>,
    @location(2) corner: vec2<f32>,
    @location(3) reach: vec3<f32>,
};
struct FlatOut {
    @builtin(position) clip: vec4<f32>,
    @location(0) colour: vec4<f32>,
    @location(1) place: vec2<f32>,
};

@vertex
fn flat_vertex(in: FlatIn) -> FlatOut {
    var out: FlatOut;
    let wide = length(in.reach.xy);
    let least = in.reach.z * view.screen.z;
    let place = in.position + in.corner + in.reach.xy * select(1.0, least / wide, wide > 0.0 && wide < least);
    out.clip = view.to_clip * vec4<f32>(place, 0.0, 1.0);
    out.colour = in.colour;
    out.place = place;
    return out;
}

@fragment
fn flat_fragment(in: FlatOut) -> @location(0) vec4<f32> {
    return in.colour;
}

// Land, water and parks under a map, with shores as sharp as the screen.
@group(1) @binding(0) var ground_map: texture_2d<f32>;

@fragment
fn ground_fragment(in: FlatOut) -> @location(0) vec4<f32> {
    let at = (in.place - view.site.xy) / view.site.zw;
    let ground = textureSample(ground_map, linear_sampler, vec2<f32>(at.x, 1.0 - at.y));
    let soft = fwidth(ground.rg) * 0.7 + vec2<f32>(1e-4);
    let land = max(smoothstep(0.5 - soft.x, 0.5 + soft.x, ground.r), 1.0 - view.strengths.z);
    let park = smoothstep(0.5 - soft.y, 0.5 + soft.y, ground.g) * view.strengths.w;
    var colour = mix(vec3<f32>(0.547, 0.644, 0.734), vec3<f32>(0.868, 0.847, 0.800), land);
    colour = mix(colour, vec3<f32>(0.594, 0.693, 0.474), park * land);
    // A shore is a thin darker line, hills a light from the north-west.
    let shore = 1.0 - smoothstep(0.0, 1.5, abs(ground.r - 0.5) / max(fwidth(ground.r), 1e-4));
    colour = mix(colour, vec3<f32>(0.25, 0.42, 0.56), shore * 0.5 * view.strengths.z);
    colour *= mix(1.0, 0.75 + 0.5 * ground.b, land);
    return vec4<f32>(colour, 1.0);
}

// A map laid over everything on a map.
@fragment
fn overlay_fragment(in: FlatOut) -> @location(0) vec4<f32> {
    return overlay_at(in.place);
}

struct ScreenOut {
    @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
};

@vertex
fn screen_vertex(@builtin(vertex_index) index: u32) -> ScreenOut {
    var out: ScreenOut;
    let uv = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    out.clip = vec4<f32>(uv * 2.0 - 1.0, 0.0, 1.0);
    out.uv = vec2<f32>(uv.x, 1.0 - uv.y);
    return out;
}

@group(1) @binding(0) var drawn: texture_2d<f32>;
@group(1) @binding(1) var depths: texture_depth_multisampled_2d;

fn distance_at(pixel: vec2<i32>) -> f32 {
    let last = vec2<i32>(view.screen.xy) - vec2<i32>(1);
    let depth = textureLoad(depths, clamp(pixel, vec2<i32>(0), last), 0);
    let near = view.screen.z;
    let far = view.screen.w;
    return near * far / max(far - depth * (far - near), 1e-6);
}

// Where something stands in front of something far behind it, the latter is darkened (Scharl 2010 §8.4, after Luft 2006).
@fragment
fn silhouette_fragment(in: ScreenOut) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(in.clip.xy);
    let colour = textureLoad(drawn, pixel, 0).rgb;
    let here = distance_at(pixel);
    var nearer = 0.0;
    for (var i = 0; i < 12; i++) {
        let turn = f32(i) * 2.399963;
        let reach = 1.0 + f32(i) * 0.45;
        let off = vec2<i32>(round(vec2<f32>(cos(turn), sin(turn)) * reach));
        let gap = (here - distance_at(pixel + off)) / here;
        nearer += smoothstep(0.004, 0.05, gap) * (1.0 - f32(i) / 14.0);
    }
    let dark = clamp(nearer / 7.0, 0.0, 1.0) * view.strengths.y;
    return vec4<f32>(colour * (1.0 - dark), 1.0);
}
