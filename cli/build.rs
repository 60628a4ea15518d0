//! Takes the drawing script of the reports, plotly.js, out of the crate that ships it.

use std::path::Path;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // The crate gives HTML: one script element with plotly.js, one with a typesetter we do not use.
    let elements = plotly::Plot::offline_js_sources();
    let script = elements
        .split("</script>")
        .filter_map(|element| element.split_once('>'))
        .map(|(_, script)| script)
        .find(|script| script.contains("* plotly.js v"))
        .expect("the plotly crate ships plotly.js in a script element");
    let directory = std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    std::fs::write(Path::new(&directory).join("plotly.min.js"), script)
        .expect("OUT_DIR is writable");
}
