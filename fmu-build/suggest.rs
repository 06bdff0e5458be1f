//! The name that was probably meant.

/// How alike two names must be, of 1.
const ALIKE: f64 = 0.6;

/// "; did you mean 'x'?" for the known name that is most like this one; empty if none is.
pub(crate) fn did_you_mean<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let all = known.into_iter();
    let alike = all.map(|known| (strsim::normalized_levenshtein(name, known), known));
    let best = alike.max_by(|(one, first), (other, second)| {
        let order = one.total_cmp(other);
        order.then_with(|| second.cmp(first))
    });
    match best {
        Some((score, known)) if score >= ALIKE => format!("; did you mean '{known}'?"),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_meant_or_none() {
        let known = ["engine.speed", "engine.torque", "vehicle.speed"];
        for (name, told) in [
            ("engine.sped", "; did you mean 'engine.speed'?"),
            ("vehicle.sped", "; did you mean 'vehicle.speed'?"),
            ("x", ""),
        ] {
            assert_eq!(did_you_mean(name, known), told);
        }
        assert_eq!(did_you_mean("x", []), "");
    }
}
