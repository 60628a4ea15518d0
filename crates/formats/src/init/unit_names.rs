//! Names of units.

/// The unit in `text`, in the spelling of mappings, lower case.
pub(super) fn unit(text: &str) -> Option<&'static str> {
    let text: String = text
        .to_lowercase()
        .chars()
        .filter(|letter| !matches!(letter, ' ' | '^' | '*' | '·' | '_' | '.' | '-'))
        .collect();
    Some(match text.as_str() {
        "rad/s" | "radps" | "rads" | "rads1" | "rad/sec" => "rad/s",
        "deg/s" | "dps" | "degps" | "degs" | "degs1" | "°/s" | "deg/sec" | "degree/s"
        | "degrees/s" => "deg/s",
        "mrad/s" | "mradps" | "mrads" => "mrad/s",
        "mdeg/s" | "mdps" | "mdegps" | "mdegs" | "millideg/s" => "mdeg/s",
        "cdeg/s" | "cdegps" | "centideg/s" | "001deg/s" | "001°/s" | "001dps" => "cdeg/s",
        "deg/h" | "deg/hr" | "deg/hour" | "degph" | "degh" | "degh1" | "°/h" | "°/hr" | "dph"
        | "degrees/h" | "degrees/hour" => "deg/h",
        "rpm" | "rev/min" | "r/min" => "rpm",
        "rad" | "radian" | "radians" => "rad",
        "deg" | "degree" | "degrees" | "°" => "deg",
        "m/s2" | "m/s/s" | "m/s²" | "mps2" | "mpss" | "ms2" | "m/sec2" => "m/s2",
        "g" | "gee" | "gs" => "g",
        "mg" | "millig" => "mg",
        "cm/s2" | "cm/s/s" | "cm/s²" | "cmps2" | "cmss" | "cmpss" => "cm/s2",
        "ft/s2" | "ft/s/s" | "ft/s²" | "ftps2" | "fps2" | "fpss" | "ft/sec2" => "ft/s2",
        "m/s" | "mps" | "ms1" | "m/sec" => "m/s",
        "ft/s" | "fps" | "ftps" | "ft/sec" => "ft/s",
        "ft/min" | "fpm" | "ftpm" => "ft/min",
        "cm/s" | "cmps" => "cm/s",
        "mm/s" | "mmps" => "mm/s",
        "km/h" | "kmh" | "kph" | "kmph" => "km/h",
        "mph" | "mi/h" => "mph",
        "kn" | "kt" | "kts" | "knots" | "knot" => "kn",
        "gauss" | "ga" => "gauss",
        "mgauss" | "milligauss" => "mg",
        "ut" | "µt" | "μt" | "utesla" | "microtesla" => "ut",
        "nt" | "nanotesla" => "nt",
        "tesla" | "t" => "t",
        "days" | "day" => "d",
        "s" | "sec" | "secs" | "seconds" | "second" => "s",
        "ms" | "msec" | "millis" | "milliseconds" => "ms",
        "us" | "usec" | "µs" | "μs" | "micros" | "microseconds" => "us",
        "ns" | "nsec" | "nanos" | "nanoseconds" => "ns",
        "m" | "meter" | "meters" | "metre" | "metres" => "m",
        "cm" => "cm",
        "mm" => "mm",
        "ft" | "feet" => "ft",
        "pa" | "pascal" => "pa",
        "hpa" | "mbar" | "millibar" => "hpa",
        "kpa" => "kpa",
        "inhg" | "inchhg" | "incheshg" => "inhg",
        "e7" | "1e7" | "dege7" | "deg1e7" | "dege/7" => "deg1e7",
        "cdeg" | "centideg" | "centidegrees" | "1e2deg" | "deg1e2" => "cdeg",
        "1e5deg" | "deg1e5" | "dege5" => "deg1e5",
        "ddmm" | "ddmmmm" | "ddmmmmmm" | "dddmmmmmm" => "ddmm",
        "%" | "percent" | "pct" => "percent",
        _ => return None,
    })
}

/// Removes the unit from the end of a name's words and returns it.
pub(super) fn trailing_unit(words: &mut Vec<String>) -> Option<&'static str> {
    for count in [3, 2, 1] {
        if words.len() > count {
            let from = words.len() - count;
            let parts = &words[from..];
            if let Some(found) = unit(&parts.join("/")).or_else(|| unit(&parts.concat())) {
                words.truncate(from);
                return Some(found);
            }
        }
    }
    None
}
