//! Imports street files and prints what became of them, one line a file:
//! `cargo run --release -p city --example import_places -- scripts/krems/krems.osm.pbf …`
//!
//! `errors` counts what breaks the graph's contract: 0 for a sound import. `diff` is path length against source length in percent.

use city::sources::{
    GeoJsonFrame, ImportLog, ImportOptions, SourceError, StreetFile, file_key, into_graph, read_geojson_streets,
    read_osm,
};
use std::path::Path;
use std::process::ExitCode;
use streets::graph::CheckLevel;
use streets::{Classes, StreetGraph};

fn main() -> ExitCode {
    println!(
        "{:<26}{:>8}{:>9}{:>9}{:>10}{:>8}{:>10}{:>8}{:>8}{:>7}{:>8}",
        "file",
        "streets",
        "nodes",
        "segments",
        "source km",
        "diff %",
        "overlap km",
        "refused",
        "merged",
        "errors",
        "skipped"
    );
    let mut is_sound = true;
    for path in std::env::args().skip(1) {
        match import(Path::new(&path)) {
            Ok(errors) => is_sound &= errors == 0,
            Err(error) => {
                eprintln!("error: {error}\n  hint: {}", error.hint());
                is_sound = false;
            }
        }
    }
    if is_sound { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn import(path: &Path) -> Result<usize, SourceError> {
    let key = file_key(path);
    let file =
        if key.ends_with("json") { read_geojson_streets(path, GeoJsonFrame::Detect)? } else { read_osm(path, None)? };
    let (graph, log) = into_graph(&file.streets, Classes::default(), &ImportOptions::new(&key));
    let errors = graph.check(CheckLevel::Sweep).len();
    print_line(&key, &file, &graph, &log, errors);
    Ok(errors)
}

fn print_line(key: &str, file: &StreetFile, graph: &StreetGraph, log: &ImportLog, errors: usize) {
    println!(
        "{key:<26}{:>8}{:>9}{:>9}{:>10.2}{:>8.3}{:>10.2}{:>8}{:>8}{errors:>7}{:>8}",
        log.streets,
        graph.node_count(),
        graph.segment_count(),
        log.source_length / 1000.0,
        (log.path_length / log.source_length - 1.0) * 100.0,
        log.overlapped_length() / 1000.0,
        log.refused.len(),
        log.merged_points,
        file.left_out.values().sum::<usize>(),
    );
    for refused in log.refused.iter().take(5) {
        println!("    {refused}");
    }
}
