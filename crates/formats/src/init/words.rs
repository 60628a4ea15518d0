//! Words of column names.

/// Words of phone loggers in German, French, Italian and Spanish, in lower case, with the English word.
#[rustfmt::skip]
const ENGLISH: [(&str, &[&str]); 13] = [
    ("time", &["zeit", "temps", "tempo", "tiempo"]),
    ("gyroscope", &["gyroskop", "drehrate", "giroscopio", "giroscópio"]),
    ("acceleration", &["beschleunigung", "accélération", "accélérometre", "accéléromètre", "accelerazione", "aceleración"]),
    ("linear", &["lineare", "linéaire", "lineal"]),
    ("without", &["ohne", "sans", "senza"]),
    ("latitude", &["breite", "breitengrad", "latitudine", "latitud"]),
    ("longitude", &["länge", "längengrad", "longitudine", "longitud"]),
    ("height", &["höhe", "hoehe", "hauteur", "altezza", "altura"]),
    ("speed", &["geschwindigkeit", "vitesse", "velocità", "velocidad"]),
    ("direction", &["richtung", "direzione", "dirección"]),
    ("accuracy", &["genauigkeit", "précision", "precisione", "precisión"]),
    ("horizontal", &["horizontale", "orizzontale"]),
    ("vertical", &["vertikale", "verticale"]),
];

/// The English word for `word`, if it is one of those of a phone logger in another language.
fn english(word: String) -> String {
    let of_word = ENGLISH.iter().find(|(_, others)| others.contains(&word.as_str()));
    of_word.map_or(word, |(english, _)| (*english).to_owned())
}

/// The name without its bracketed part, and the text in the brackets.
pub(super) fn bracketed(name: &str) -> (&str, String) {
    // The text in brackets is a unit.
    let Some(open) = name.find(['[', '(', '{']) else { return (name, String::new()) };
    let inside = name[open..].trim_matches(['[', ']', '(', ')', '{', '}', ' ']);
    (&name[..open], inside.to_owned())
}

/// The words of a name, in lower case and in English: split at punctuation and before each capital that follows a small
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
    words.into_iter().map(english).collect()
}
