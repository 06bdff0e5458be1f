//! Units as an FMU defines them, and how a value passes from one to another.

use roxmltree::Node;

/// SI base units, in the order of the exponents.
pub const BASES: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

/// A unit: value in SI = factor * value + offset.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Its name in the FMU.
    pub name: String,
    /// Exponents of kg, m, s, A, K, mol, cd, rad.
    pub exponents: [i32; 8],
    /// Factor to SI.
    pub factor: f64,
    /// Offset to SI.
    pub offset: f64,
}

impl Unit {
    /// Reads `<Unit name="…"><BaseUnit …/></Unit>`, with its name; none without a BaseUnit that a value can pass
    /// through both ways.
    pub fn read(node: Node<'_, '_>) -> Option<(String, Self)> {
        let name = node.attribute("name")?.to_owned();
        let base = node.children().find(|node| node.has_tag_name("BaseUnit"))?;
        let number = |name, otherwise| match base.attribute(name) {
            Some(text) => text.parse::<f64>().ok(),
            None => Some(otherwise),
        };
        let exponent =
            |base_name: &str| base.attribute(base_name).and_then(|text| text.parse().ok());
        let (factor, offset) = (number("factor", 1.0)?, number("offset", 0.0)?);
        if !factor.is_normal() || !offset.is_finite() {
            return None;
        }
        let unit = Self {
            name: name.clone(),
            exponents: BASES.map(|base| exponent(base).unwrap_or_default()),
            factor,
            offset,
        };
        Some((name, unit))
    }

    /// A coherent unit: its values are in SI.
    pub fn named(name: &str, exponents: [i32; 8]) -> Self {
        Self {
            name: name.to_owned(),
            exponents,
            factor: 1.0,
            offset: 0.0,
        }
    }

    /// The unit for differences, which has no offset.
    #[must_use]
    pub fn difference(self) -> Self {
        Self {
            offset: 0.0,
            ..self
        }
    }

    /// Exponents as text, `kg m2 s-2`; `1` for none.
    pub fn dimension(&self) -> String {
        let bases = BASES.iter().zip(self.exponents);
        let parts = bases.filter(|(_, exponent)| *exponent != 0);
        let parts: Vec<String> = parts
            .map(|(base, exponent)| match exponent {
                1 => (*base).to_owned(),
                exponent => format!("{base}{exponent}"),
            })
            .collect();
        if parts.is_empty() {
            return "1".to_owned();
        }
        parts.join(" ")
    }

    /// Factor and offset of target value = factor * value + offset; none when the two measure
    /// different quantities.
    pub fn conversion(&self, target: &Self) -> Option<(f64, f64)> {
        (self.exponents == target.exponents).then(|| {
            let offset = (self.offset - target.offset) / target.factor;
            (self.factor / target.factor, offset)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(xml: &str) -> Unit {
        let document = roxmltree::Document::parse(xml).unwrap();
        Unit::read(document.root_element()).unwrap().1
    }

    #[test]
    fn degrees_become_kelvin_and_never_metres() {
        let celsius = unit(r#"<Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>"#);
        let kelvin = unit(r#"<Unit name="K"><BaseUnit K="1"/></Unit>"#);
        let metre = unit(r#"<Unit name="m"><BaseUnit m="1"/></Unit>"#);
        assert_eq!(celsius.conversion(&kelvin), Some((1.0, 273.15)));
        assert_eq!(kelvin.conversion(&celsius), Some((1.0, -273.15)));
        assert_eq!(
            celsius.clone().difference().conversion(&kelvin),
            Some((1.0, 0.0))
        );
        assert_eq!(celsius.conversion(&metre), None);
    }

    #[test]
    fn a_unit_that_nothing_passes_through_is_none() {
        for base in [
            r#"factor="0""#,
            r#"factor="NaN""#,
            r#"offset="inf""#,
            r#"factor="x""#,
        ] {
            let xml = format!(r#"<Unit name="u"><BaseUnit m="1" {base}/></Unit>"#);
            let document = roxmltree::Document::parse(&xml).unwrap();
            assert_eq!(Unit::read(document.root_element()), None, "{base}");
        }
    }
}
