//! Plat inside another program: load a city, change a parameter, build it, read what came out.
//!
//! `cargo run --example embed -- scripts/lattice`

use city::{Cancel, Settings, Silent, build, load};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from("scripts/lattice"), PathBuf::from);
    let mut loaded = load(&folder, None)?;
    loaded.set("minors.pattern.block_width=200").map_err(|error| error.to_string())?;
    let sources = loaded.read()?;
    let built = build(&sources, Settings::default(), &Silent, &Cancel::default())?;
    for block in built.city.blocks.iter().take(3) {
        println!("block {} has {:.0} m²", block.id, block.polygon.area());
    }
    println!("{} parcels, {} buildings", built.city.parcels.len(), built.city.buildings.len());
    Ok(())
}
