//! A topological map (C4): places, doors, and the shortest path between two rooms.

use loc_maps::TopologicalMap;

const FLAT: &str = r#"
[[place]]
name = "kitchen"
kind = "room"
position = [1.0, 2.0]

[[place]]
name = "kitchen door"
kind = "door"
position = [3.0, 2.0]
width = 0.9

[[place]]
name = "hall"
kind = "corridor"
position = [4.0, 5.0]

[[edge]]
between = ["kitchen", "kitchen door"]

[[edge]]
between = ["kitchen door", "hall"]
length = 3.5
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let map = TopologicalMap::parse_toml("flat.toml", FLAT)?;
    let (Some(kitchen), Some(hall)) = (map.find("kitchen"), map.find("hall")) else {
        return Err("the flat has a kitchen and a hall".into());
    };
    match map.shortest_path(kitchen, hall) {
        Some(route) => println!("{} places, {:.1} m", route.places.len(), route.length),
        None => println!("no way from the kitchen to the hall"),
    }
    Ok(())
}
