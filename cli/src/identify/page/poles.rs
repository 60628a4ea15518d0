//! The poles with their regions of uncertainty.

use hovernav_model::ModelError;
use hovernav_sysid::helicopter::Identification;
use hovernav_sysid::helicopter::Pole;

use hovernav_pages::{Axis, Figure, Role, Row, Section, Series, Table, TableRow, digits};

/// The poles of `found`, and the poles from held GPS velocity.
pub fn poles(found: &Identification, held: Option<&Identification>) -> Result<Section, ModelError> {
    let poles = found.identified.poles()?;
    let others = match held {
        Some(held) => held.identified.poles()?,
        None => Vec::new(),
    };
    let outlines = |poles: &[Pole]| -> Vec<(f64, f64)> {
        let gap = (f64::NAN, f64::NAN);
        let outlines = poles.iter().map(|pole| pole.region_95(61));
        outlines
            .flat_map(|outline| outline.into_iter().map(|at| (at.re, at.im)).chain([gap]))
            .collect()
    };
    let marks = |role, poles: &[Pole]| {
        Series::points(role, poles.iter().map(|pole| (pole.value.re, pole.value.im)))
    };
    let figure = |[left, right, up]: [f64; 3], caption: &str| {
        let row = Row { limits: Some([-up, up]), ..Row::new("Imaginary part", "1/s") }
            .with(
                Series::curve(Role::Limit, [(0.0, -10.0 * up), (0.0, 10.0 * up)])
                    .named("Stability limit"),
            )
            .with(Series::curve(Role::AlternativeRegion, outlines(&others)))
            .with(marks(Role::AlternativePole, &others).named("From held GPS velocity"))
            .with(Series::curve(Role::Region, outlines(&poles)).named("95 % region"))
            .with(marks(Role::Pole, &poles).named("Pole"));
        let axis = Axis::plane("Real part", "1/s").within([left, right]);
        Figure::against(axis, [row]).captioned(caption)
    };
    let most = |part: fn(&Pole) -> f64| poles.iter().map(part).fold(0.0, f64::max);
    let (left, right, up) =
        (most(|pole| -pole.value.re), most(|pole| pole.value.re), most(|pole| pole.value.im));
    let size = left.max(right).max(up).max(0.1);
    let whole = [-left - 0.1 * size, right + 0.2 * size, up + 0.2 * size];
    let mut section = Section::new(
        "poles",
        "Poles",
        "Eigenvalues of the vehicle in continuous time. Poles further left decay faster, poles right of the dashed \
         line are unstable, and poles off the real axis oscillate. Each pole has its 95 % region, derived from the \
         bounds of the parameters. For a real pole this region is an interval on the axis.",
    )
    .with(figure(whole, "All"));
    if size > 5.0 && poles.len() > 1 {
        let near = [-1.5, 0.5, 0.6];
        section = section.with(figure(near, "Near the origin: the slow motion over ground"));
    }
    let rows = poles.iter().map(|Pole { value, covariance }| {
        let sigma = |axis: usize| digits(covariance[(axis, axis)].max(0.0).sqrt());
        let imaginary = if value.im == 0.0 {
            "0".into()
        } else {
            format!("{} ±{}", digits(value.im), sigma(1))
        };
        let size = value.norm();
        let damping = if size > 1e-9 { digits(-value.re / size) } else { "–".into() };
        TableRow::new(
            format!("{} ±{}", digits(value.re), sigma(0)),
            vec![imaginary, digits(size), damping],
        )
    });
    let heads = ["Real part ±1σ, 1/s", "Imaginary part ±1σ, 1/s", "Frequency, rad/s", "Damping"];
    Ok(section.with(Table {
        caption: "Poles, fastest decay first".into(),
        heads: heads.map(Into::into).into(),
        rows: rows.collect(),
    }))
}
