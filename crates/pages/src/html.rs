//! Escaped text, and a template with placeholders.

use std::fmt::{self, Write as _};
use std::io::{self, Write};

/// Copies `template` and calls `place` for each placeholder `{{name}}`. The output of `place` is not scanned again, so
/// text cannot act as a placeholder.
pub fn fill<W: Write>(
    out: &mut W,
    template: &str,
    mut place: impl FnMut(&mut W, &str) -> io::Result<()>,
) -> io::Result<()> {
    let mut rest = template;
    while let Some((before, (name, after))) =
        rest.split_once("{{").and_then(|(before, after)| Some((before, after.split_once("}}")?)))
    {
        out.write_all(before.as_bytes())?;
        place(out, name)?;
        rest = after;
    }
    out.write_all(rest.as_bytes())
}

/// Plain text, escaped for an HTML element or a quoted attribute.
pub struct Escaped<'a>(pub &'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for character in self.0.chars() {
            match character {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                '\'' => f.write_str("&#39;")?,
                _ => f.write_char(character)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_become_markup() {
        assert_eq!(
            Escaped(r#"<b onclick="x('&amp;')">"#).to_string(),
            "&lt;b onclick=&quot;x(&#39;&amp;amp;&#39;)&quot;&gt;"
        );
    }

    #[test]
    fn what_fills_a_place_is_not_filled_again() {
        let mut out = Vec::new();
        fill(&mut out, "a{{x}}b{{x}}c{{", |out, name| write!(out, "{{{{{name}}}}}")).unwrap();
        assert_eq!(out, b"a{{x}}b{{x}}c{{");
    }
}
