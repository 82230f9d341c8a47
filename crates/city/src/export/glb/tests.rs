use super::*;
use crate::export::samples::{hilly_city, small_city};

fn to_bytes(model: &Model) -> Result<Vec<u8>, GlbError> {
    let mut bytes = Vec::new();
    write(model, &mut bytes).map(|()| bytes)
}

#[test]
fn the_file_reads_back_with_what_went_in() {
    let model = model(&hilly_city(), &Cache::none());
    let bytes = to_bytes(&model).unwrap();
    let (document, buffers, _) = gltf::import_slice(&bytes).unwrap();
    let scene = document.default_scene().unwrap();
    let tiles: Vec<_> = scene.nodes().collect();
    assert_eq!(tiles.len(), model.tiles.len());
    assert!(tiles.iter().all(|tile| tile.name().is_some_and(|name| name.starts_with("tile "))));
    for (tile, (key, meshes)) in tiles.iter().zip(&model.tiles) {
        let (translation, ..) = tile.transform().decomposed();
        assert_eq!(translation, [key.origin().x as f32, 0.0, -key.origin().y as f32]);
        let primitives: Vec<_> =
            tile.children().flat_map(|child| child.mesh().unwrap().primitives().collect::<Vec<_>>()).collect();
        assert_eq!(primitives.len(), meshes.len());
        for (primitive, mesh) in primitives.iter().zip(meshes.values()) {
            let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(|data| &data.0[..]));
            assert_eq!(reader.read_positions().unwrap().collect::<Vec<_>>(), mesh.positions);
            assert_eq!(reader.read_normals().unwrap().collect::<Vec<_>>(), mesh.normals);
            assert_eq!(reader.read_indices().unwrap().into_u32().collect::<Vec<_>>(), mesh.indices);
        }
    }
}

#[test]
fn every_mesh_is_sound() {
    for city in [small_city(), hilly_city()] {
        for mesh in model(&city, &Cache::none()).tiles.values().flat_map(|tile| tile.values()) {
            assert_eq!(mesh.positions.len(), mesh.normals.len());
            assert!(mesh.indices.iter().all(|&i| (i as usize) < mesh.positions.len()));
            assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()));
            let length = |n: &[f32; 3]| n.iter().map(|x| x * x).sum::<f32>();
            assert!(mesh.normals.iter().all(|n| (length(n) - 1.0).abs() < 1e-4));
        }
    }
}

#[test]
fn the_bytes_are_the_same_every_time() {
    let bytes = || to_bytes(&model(&small_city(), &Cache::none())).unwrap();
    assert_eq!(bytes(), bytes());
}

#[test]
fn streets_lie_on_the_terrain_as_it_is_drawn() {
    let mut city = hilly_city();
    city.runs.retain(|run| run.level == 0);
    let terrain = terrain::Terrain::of(&city);
    let model = model(&city, &Cache::none());
    let mut seen = 0;
    for (key, tile) in &model.tiles {
        for (_, mesh) in
            tile.iter().filter(|((group, surface), _)| *group == Group::Streets && *surface == Surface::Minor)
        {
            for corners in mesh.triangles() {
                let middle = corners
                    .iter()
                    .fold([0.0; 3], |sum, c| [sum[0] + c[0] / 3.0, sum[1] + c[1] / 3.0, sum[2] + c[2] / 3.0]);
                let place = key.origin() + Vec2::new(f64::from(middle[0]), -f64::from(middle[2]));
                let above = f64::from(middle[1]) - terrain.height(place);
                assert!((0.099..0.121).contains(&above), "{above} m above the terrain at {place}");
                seen += 1;
            }
        }
    }
    assert!(seen > 500, "{seen}");
}

#[test]
fn buildings_stand_in_the_ground() {
    let city = hilly_city();
    let model = model(&city, &Cache::none());
    let heights = |surface: Surface| {
        let meshes = model.tiles.values().filter_map(move |tile| tile.get(&(Group::Buildings, surface)));
        meshes.flat_map(|mesh| mesh.positions.iter().map(|p| f64::from(p[1])))
    };
    let lowest = city.buildings.iter().map(|b| b.ground.0).fold(f64::MAX, f64::min);
    let highest = city.buildings.iter().map(|b| b.ground.1 + b.height).fold(f64::MIN, f64::max);
    assert!((heights(Surface::Wall).fold(f64::MAX, f64::min) - (lowest - terrain::ERROR_M)).abs() < 1e-3);
    assert!((heights(Surface::Roof).fold(f64::MIN, f64::max) - highest).abs() < 1e-3);
}

#[test]
fn kept_meshes_are_those_that_would_be_made() {
    let cache = Cache::in_memory();
    let mut city = hilly_city();
    city.digests = crate::Digests { site: Some(Id(1)), streets: Some(Id(2)), land: None };
    let before = model(&city, &cache);
    assert_eq!(before, model(&city, &Cache::none()));
    let shares = |model: &Model, group: Group| {
        let all =
            before.tiles.iter().flat_map(|(key, tile)| tile.iter().map(move |(surface, mesh)| (key, surface, mesh)));
        let mut of_group = all.filter(|(_, surface, _)| surface.0 == group);
        let shared = |(key, surface, mesh): (&TileKey, &(Group, Surface), &Arc<Mesh>)| {
            model.tiles.get(key).and_then(|tile| tile.get(surface)).is_some_and(|other| Arc::ptr_eq(mesh, other))
        };
        of_group.all(shared)
    };
    Arc::make_mut(&mut city.buildings).pop();
    let after = model(&city, &cache);
    assert_eq!(after, model(&city, &Cache::none()));
    assert!(shares(&after, Group::Terrain) && shares(&after, Group::Streets) && !shares(&after, Group::Buildings));
    city.digests.streets = Some(Id(3));
    city.runs.pop();
    assert_eq!(model(&city, &cache), model(&city, &Cache::none()));
}

#[test]
fn kept_tiles_are_those_that_would_be_made() {
    type Change = (&'static str, fn(&mut City));
    let changes: [Change; 6] = [
        ("all new", |_| {}),
        ("a building less", |city| drop(Arc::make_mut(&mut city.buildings).pop())),
        ("a taller building", |city| Arc::make_mut(&mut city.buildings)[0].height += 1.0),
        ("a wider street", |city| city.runs[0].half_width *= 2),
        ("a bridge becomes a tunnel", |city| {
            city.runs.iter_mut().filter(|run| run.level > 0).for_each(|run| run.level = -run.level);
        }),
        ("parks become plazas", |city| {
            Arc::make_mut(&mut city.parcels)
                .iter_mut()
                .filter(|p| p.usage == layout::Use::Park)
                .for_each(|p| p.usage = layout::Use::Plaza);
        }),
    ];
    let cache = Cache::in_memory();
    let mut city = hilly_city();
    city.digests.site = Some(Id(1));
    assert!(city.runs.iter().any(|run| run.level > 0));
    let mut before = Model::default();
    for (name, change) in changes {
        change(&mut city);
        let fresh = model(&city, &Cache::none());
        assert!(model(&city, &cache) == fresh, "{name}");
        assert!(before != fresh, "{name} shows");
        before = fresh;
    }
}

#[test]
fn tiles_without_a_change_are_not_made_again() {
    let cache = Cache::in_memory();
    let mut city = hilly_city();
    city.digests.site = Some(Id(1));
    let before = model(&city, &cache);
    let tile = TileKey::of(city.buildings[0].footprint.outer[0].metres());
    Arc::make_mut(&mut city.buildings)[0].height += 1.0;
    let after = model(&city, &cache);
    assert!(after.tiles.len() > 1);
    for (key, meshes) in &after.tiles {
        for (place, mesh) in meshes {
            let is_changed = *key == tile && place.0 == Group::Buildings;
            assert_eq!(std::sync::Arc::ptr_eq(mesh, &before.tiles[key][place]), !is_changed, "{key:?} {place:?}");
        }
    }
}
