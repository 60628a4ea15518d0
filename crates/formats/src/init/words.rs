//! Words of column names.

/// The name without its bracketed part, and the text in the brackets.
pub(super) fn bracketed(name: &str) -> (&str, String) {
    // The text in brackets is a unit.
    let Some(open) = name.find(['[', '(', '{']) else { return (name, String::new()) };
    let inside = name[open..].trim_matches(['[', ']', '(', ')', '{', '}', ' ']);
    (&name[..open], inside.to_owned())
}

/// The words of a name, in lower case: split at punctuation and before each capital that follows a small
/// letter.
pub(super) fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for letter in name.chars() {
        let starts = letter.is_uppercase() && before.is_lowercase();
        if !letter.is_alphanumeric() || starts {
            words.push(String::new());
        }
        if letter.is_alphanumeric()
            && let Some(word) = words.last_mut()
        {
            word.extend(letter.to_lowercase());
        }
        before = letter;
    }
    words.retain(|word| !word.is_empty());
    words
}
