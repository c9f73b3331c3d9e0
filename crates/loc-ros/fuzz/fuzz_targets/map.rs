//! Maps of map_server: the YAML file, a zero byte, the image.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_maps::grid::io::{MapDescription, load_image};

fuzz_target!(|data: &[u8]| {
    let mut parts = data.splitn(2, |byte| *byte == 0);
    let yaml = loc_fuzz::text(parts.next().unwrap_or_default());
    if let Ok(description) = MapDescription::parse("map.yaml", &yaml) {
        // The image that the YAML file names could be any file of this machine.
        let image = loc_fuzz::file("map.pgm", parts.next().unwrap_or_default());
        let _ = load_image(image, &description);
    }
});
