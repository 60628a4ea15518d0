//! Parser of equations as text into a [`Structure`].

use super::error::StructureError;
use super::parametrised::Structure;
use super::terms::{Parameter, Term};

/// A line that is not empty, with its number.
struct Line<'a> {
    structure: &'a str,
    number: usize,
    text: &'a str,
}

impl Line<'_> {
    fn error(&self, found: &str, expected: &'static str) -> StructureError {
        StructureError::Line {
            structure: self.structure.to_owned(),
            line: self.number,
            found: found.trim().to_owned(),
            expected,
        }
    }
}

impl Structure {
    /// A structure from its equations, one per line; empty lines are ignored.
    ///
    /// | line | meaning |
    /// |---|---|
    /// | `inputs a b …` | the inputs, by their names in the experiments |
    /// | `noise n …` | process noises, optional |
    /// | `outputs y …` | the outputs; a name without an equation is the state of that name |
    /// | `offsets x …` | states with a constant forcing per experiment, optional |
    /// | `biases y …` | outputs with a constant bias per experiment, optional |
    /// | `delay a tau` | parameter `tau`, s, delays input `a`, optional |
    /// | `lag a tau` | a first-order lag of time constant `tau`, s, on input `a`, optional |
    /// | `x' = …` | a state's equation |
    /// | `y = …` | an output's equation |
    ///
    /// A right-hand side is a sum of products of numbers and parameters (`*` and `/`) with exactly one
    /// state, input or noise in each: `b' = -b/tau - p + Blat/tau*lat`. An equation may be `0`.
    ///
    /// # Errors
    /// [`StructureError`] with the line and its text.
    pub fn new(
        name: &str,
        parameters: Vec<Parameter>,
        equations: &str,
    ) -> Result<Self, StructureError> {
        parse(name, parameters, equations)
    }
}

fn parse(name: &str, parameters: Vec<Parameter>, text: &str) -> Result<Structure, StructureError> {
    let mut structure = Structure {
        name: name.to_owned(),
        states: Vec::new(),
        inputs: Vec::new(),
        outputs: Vec::new(),
        noises: Vec::new(),
        offsets: Vec::new(),
        biases: Vec::new(),
        parameters,
        delays: Vec::new(),
        lags: Vec::new(),
        dynamics: Vec::new(),
        measurement: Vec::new(),
        bias_rows: Vec::new(),
    };
    for parameter in &structure.parameters {
        let inside = parameter.lower <= parameter.start && parameter.start <= parameter.upper;
        if !(inside && parameter.start.is_finite()) {
            return Err(StructureError::Bounds {
                structure: name.to_owned(),
                parameter: parameter.name.clone(),
            });
        }
    }

    let mut equations = Vec::new();
    let (mut delays, mut lags) = (Vec::new(), Vec::new());
    for (index, text) in text.lines().enumerate() {
        let line = Line { structure: name, number: index + 1, text: text.trim() };
        if line.text.is_empty() {
            continue;
        }
        if let Some((left, right)) = line.text.split_once('=') {
            let left = left.trim();
            if let Some(state) = left.strip_suffix('\'') {
                structure.states.push(state.to_owned());
            }
            equations.push((left, right, line));
            continue;
        }
        let mut words = line.text.split_whitespace();
        let keyword = words.next().unwrap_or_default();
        let names = words.map(str::to_owned).collect::<Vec<_>>();
        match keyword {
            "inputs" => structure.inputs = names,
            "outputs" => structure.outputs = names,
            "noise" => structure.noises = names,
            "offsets" => structure.offsets = names,
            "biases" => structure.biases = names,
            "delay" => delays.push((names, line)),
            "lag" => lags.push((names, line)),
            _ => {
                let expected = "an equation, inputs, outputs, noise, offsets, biases, delay or lag";
                return Err(line.error(keyword, expected));
            }
        }
    }
    if structure.states.is_empty() || structure.outputs.is_empty() {
        return Err(StructureError::Empty { structure: name.to_owned() });
    }

    for (left, right, line) in &equations {
        let (row, is_dynamics) = match left.strip_suffix('\'') {
            Some(state) => (position(&structure.states, state), true),
            None => (position(&structure.outputs, left), false),
        };
        let row = row.ok_or_else(|| line.error(left, "the name of an output"))?;
        let terms = sum(&structure, row, right, line)?;
        let seen = structure.states.len() + structure.inputs.len();
        if is_dynamics {
            structure.dynamics.extend(terms);
        } else if terms.iter().all(|term| term.column < seen) {
            structure.measurement.extend(terms);
        } else {
            return Err(line.error(right, "states and inputs only in an output"));
        }
    }
    structure.delays = by_input(&structure, &delays)?;
    structure.lags = by_input(&structure, &lags)?;
    complete(&mut structure, &equations)?;
    Ok(structure)
}

/// The parameter of each input, from `lines` that name an input and a parameter.
fn by_input(
    structure: &Structure,
    lines: &[(Vec<String>, Line<'_>)],
) -> Result<Vec<Option<usize>>, StructureError> {
    let mut found = vec![None; structure.inputs.len()];
    for (names, line) in lines {
        let [input, parameter] = names.as_slice() else {
            return Err(line.error(line.text, "an input and a parameter"));
        };
        let input = position(&structure.inputs, input)
            .ok_or_else(|| line.error(input, "the name of an input"))?;
        let parameter = structure
            .parameter(parameter)
            .ok_or_else(|| line.error(parameter, "the name of a parameter"))?;
        found[input] = Some(parameter);
    }
    Ok(found)
}

/// Adds what the lists of names imply: plain outputs, offsets, biases.
fn complete(
    structure: &mut Structure,
    equations: &[(&str, &str, Line<'_>)],
) -> Result<(), StructureError> {
    let whole = Line { structure: &structure.name.clone(), number: 1, text: "" };
    for (row, output) in structure.outputs.iter().enumerate() {
        if equations.iter().any(|(left, ..)| left == output) {
            continue;
        }
        let column = position(&structure.states, output)
            .ok_or_else(|| whole.error(output, "an output that is a state or has an equation"))?;
        structure.measurement.push(Term::plain(row, column));
    }
    let first = structure.width() - structure.offsets.len();
    for (index, offset) in structure.offsets.iter().enumerate() {
        let row = position(&structure.states, offset)
            .ok_or_else(|| whole.error(offset, "the name of a state to offset"))?;
        structure.dynamics.push(Term::plain(row, first + index));
    }
    for bias in &structure.biases {
        let row = position(&structure.outputs, bias)
            .ok_or_else(|| whole.error(bias, "the name of an output to bias"))?;
        structure.bias_rows.push(row);
    }
    let used = |index: usize| {
        let terms = structure.dynamics.iter().chain(&structure.measurement);
        structure.delays.contains(&Some(index))
            || structure.lags.contains(&Some(index))
            || terms.flat_map(|term| &term.factors).any(|factor| factor.0 == index)
    };
    match (0..structure.parameters.len()).find(|&index| !used(index)) {
        Some(index) => Err(StructureError::Unused {
            structure: structure.name.clone(),
            parameter: structure.parameters[index].name.clone(),
        }),
        None => Ok(()),
    }
}

fn position(names: &[String], name: &str) -> Option<usize> {
    names.iter().position(|known| known == name)
}

/// The products of a right-hand side.
fn sum(
    structure: &Structure,
    row: usize,
    text: &str,
    line: &Line<'_>,
) -> Result<Vec<Term>, StructureError> {
    if text.trim() == "0" {
        return Ok(Vec::new());
    }
    let mut terms = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let (sign, body) = match rest.strip_prefix('-') {
            Some(body) => (-1.0, body),
            None => (1.0, rest.strip_prefix('+').unwrap_or(rest)),
        };
        let end = body.find(['+', '-']).unwrap_or(body.len());
        terms.push(product(structure, row, sign, &body[..end], line)?);
        rest = body[end..].trim_start();
    }
    Ok(terms)
}

fn product(
    structure: &Structure,
    row: usize,
    sign: f64,
    text: &str,
    line: &Line<'_>,
) -> Result<Term, StructureError> {
    let signals = || structure.states.iter().chain(&structure.inputs).chain(&structure.noises);
    let mut term = Term { row, column: usize::MAX, coefficient: sign, factors: Vec::new() };
    let mut power = 1;
    for piece in text.split_inclusive(['*', '/']) {
        let word = piece.trim_end_matches(['*', '/']).trim();
        if let Ok(number) = word.parse::<f64>() {
            term.coefficient *= number.powi(power);
        } else if let Some(index) = structure.parameter(word) {
            match term.factors.iter_mut().find(|factor| factor.0 == index) {
                Some(factor) => factor.1 += power,
                None => term.factors.push((index, power)),
            }
        } else if let Some(column) = signals().position(|signal| signal == word) {
            if term.column != usize::MAX || power < 0 {
                return Err(line.error(text, "one state, input or noise in each product"));
            }
            term.column = column;
        } else {
            return Err(line.error(word, "a number, a parameter, a state, an input or a noise"));
        }
        power = if piece.ends_with('/') { -1 } else { 1 };
    }
    if term.column == usize::MAX {
        return Err(line.error(text, "a state, an input or a noise in each product"));
    }
    Ok(term)
}
