//! A model with one variable of every sort, described.

use super::describe;
use crate::{Error, Result};
use fmi2_cosim::{
    Alias, Enumeration, Experiment, Failure, Item, Log, Model, StateFields, Unit, Variable,
};

static MODE: Enumeration = Enumeration {
    name: "Mode",
    description: "What it does",
    items: &[
        Item {
            name: "off",
            value: 1,
            description: "Off",
        },
        Item {
            name: "on",
            value: 2,
            description: "On & \"up\"",
        },
    ],
};

#[derive(Clone)]
struct Sample {
    speed: f64,
    rate: f64,
    gear: i32,
    mode: i32,
    radius: f64,
    enabled: bool,
    torque: f64,
    file: String,
    pi: f64,
}

impl Default for Sample {
    fn default() -> Self {
        Self {
            speed: 0.1 + 0.2,
            rate: 0.0,
            gear: 3,
            mode: 2,
            radius: 1e-7,
            enabled: true,
            torque: 0.0,
            file: "a&b.csv".into(),
            pi: 3.25,
        }
    }
}

impl Model for Sample {
    const NAME: &'static str = "Sample";
    const DESCRIPTION: &'static str = "a < b";
    const EXPERIMENT: Experiment = Experiment {
        start: 0.0,
        stop: 30.0,
        step: 1e-3,
    };
    const VARIABLES: &'static [Variable<Self>] = &[
        Variable::input(
            "shaft.speed",
            Unit::RADIAN_PER_SECOND,
            |m: &mut Self| &mut m.speed,
            "w",
        )
        .rate(|m: &mut Self| &mut m.rate),
        Variable::integer_input("gear", |m: &mut Self| &mut m.gear, "Gear")
            .min(0.0)
            .max(6.0),
        Variable::enumeration_parameter("mode", &MODE, |m: &mut Self| &mut m.mode, "Mode"),
        Variable::parameter("radius", Unit::METRE, |m: &mut Self| &mut m.radius, "r").tunable(),
        Variable::boolean_parameter("enabled", |m: &mut Self| &mut m.enabled, "Enabled"),
        Variable::output(
            "torque",
            Unit::NEWTON_METRE,
            |m: &mut Self| &mut m.torque,
            "T",
        )
        .depends_on(&["gear", "shaft.speed"])
        .initially_depends_on(&[])
        .aliases(&[Alias::output("shaft.torque", "T_s"), Alias::local("T", "T")]),
        Variable::output(
            "friction",
            Unit::NEWTON_METRE,
            |m: &mut Self| &mut m.torque,
            "T_f",
        )
        .depends_on(&[])
        .relative()
        .local(),
        Variable::string_parameter("file", |m: &mut Self| &mut m.file, "File"),
        Variable::output("pi", Unit::ONE, |m: &mut Self| &mut m.pi, "π")
            .constant()
            .aliases(&[Alias::local("half.turn", "π")]),
    ];

    fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> std::result::Result<(), Failure> {
        Ok(())
    }

    fn step(&mut self, _: f64, _: f64, _: &mut Log<'_>) -> std::result::Result<(), Failure> {
        Ok(())
    }

    fn hidden_state(&mut self, _: &mut dyn StateFields) {}
}

/// The text between the first `<tag` and the end of that element or tag.
fn element(text: &str, tag: &str) -> String {
    let from = text.find(&format!("<{tag}")).unwrap();
    let rest = &text[from..];
    let end = rest
        .find(&format!("</{tag}>"))
        .or_else(|| rest.find("/>"))
        .unwrap();
    rest[..end].split_whitespace().collect::<Vec<_>>().join(" ")
}

fn text() -> String {
    describe::<Sample>().unwrap()
}

#[test]
fn start_values_are_the_models_own_to_the_last_bit() {
    let text = text();
    assert!(text.contains("start=\"0.30000000000000004\""), "{text}");
    assert!(text.contains("start=\"1e-7\""), "{text}");
    assert!(text.contains("<Boolean start=\"true\"/>"), "{text}");
    assert!(text.contains("<String start=\"a&amp;b.csv\"/>"), "{text}");
    assert!(
        text.contains("<Integer min=\"0\" max=\"6\" start=\"3\"/>"),
        "{text}"
    );
    assert!(
        text.contains("<Enumeration declaredType=\"Mode\" start=\"2\"/>"),
        "{text}"
    );
}

#[test]
fn computed_variables_have_no_start_value() {
    assert_eq!(text().matches("<Real unit=\"N.m\"/>").count(), 3);
}

#[test]
fn a_difference_is_a_relative_quantity() {
    assert!(variable("friction").ends_with("<Real unit=\"N.m\" relativeQuantity=\"true\"/>"));
    assert_eq!(text().matches("relativeQuantity").count(), 1);
}

#[test]
fn text_is_escaped() {
    assert!(text().contains("description=\"a &lt; b\""));
    assert!(text().contains("description=\"On &amp; &quot;up&quot;\""));
}

#[test]
fn dependencies_are_sorted_indices_counted_from_one() {
    assert_eq!(
        element(&text(), "Outputs"),
        "<Outputs> <Unknown index=\"6\" dependencies=\"1 2\"/> <Unknown index=\"9\" dependencies=\"\"/> \
         <Unknown index=\"10\" dependencies=\"1 2\"/>"
    );
    assert_eq!(
        element(&text(), "InitialUnknowns"),
        "<InitialUnknowns> <Unknown index=\"6\" dependencies=\"\"/> <Unknown index=\"10\" dependencies=\"\"/>"
    );
}

/// The element of a variable.
fn variable(name: &str) -> String {
    let text = text();
    let from = text
        .find(&format!("<ScalarVariable name=\"{name}\""))
        .unwrap();
    let rest = &text[from..];
    let end = rest.find("</ScalarVariable>").unwrap();
    rest[..end].split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn an_alias_has_the_value_reference_of_its_row_behind_all_rows() {
    assert_eq!(
        variable("shaft.torque"),
        "<ScalarVariable name=\"shaft.torque\" valueReference=\"5\" description=\"T_s\" causality=\"output\" \
         variability=\"continuous\" initial=\"calculated\"> <Real unit=\"N.m\"/>"
    );
    assert!(variable("T").contains("valueReference=\"5\" description=\"T\" causality=\"local\""));
    let text = text();
    let names = text.match_indices("<ScalarVariable name=\"");
    let names = names.map(|(at, tag)| text[at + tag.len()..].split('"').next().unwrap());
    let names: Vec<_> = names.skip(8).collect();
    assert_eq!(names, ["pi", "shaft.torque", "T", "half.turn"]);
}

#[test]
fn a_constant_has_its_value_under_all_its_names() {
    let tail = "variability=\"constant\" initial=\"exact\"> <Real unit=\"1\" start=\"3.25\"/>";
    for (name, causality) in [("pi", "output"), ("half.turn", "local")] {
        let found = variable(name);
        let expected =
            format!("valueReference=\"8\" description=\"π\" causality=\"{causality}\" {tail}");
        assert!(found.ends_with(&expected), "{found}");
    }
}

#[test]
fn only_units_in_use_are_defined_each_once() {
    let definitions = element(&text(), "UnitDefinitions");
    assert_eq!(definitions.matches("<Unit ").count(), 4, "{definitions}");
    assert_eq!(definitions.matches("name=\"N.m\"").count(), 1);
    assert!(
        definitions.contains("<BaseUnit kg=\"1\" m=\"2\" s=\"-2\"/>"),
        "{definitions}"
    );
    assert!(definitions.contains("<DisplayUnit name=\"rpm\" factor=\"9.549296585513721\"/>"));
}

#[test]
fn derivatives_are_offered_where_a_row_has_them() {
    let tag = element(&text(), "CoSimulation");
    assert!(tag.contains("canInterpolateInputs=\"true\""), "{tag}");
    assert!(!tag.contains("maxOutputDerivativeOrder"), "{tag}");
}

#[test]
fn a_dependency_that_is_no_variable_is_named() {
    let row = Variable::output("y", Unit::ONE, |m: &mut Sample| &mut m.torque, "y");
    let result: Result<_> = super::structure::model_structure(&[row.depends_on(&["u"])]);
    let error = result.err().unwrap();
    assert!(matches!(&error, Error::UnknownDependency { dependency, .. } if dependency == "u"));
    assert_eq!(
        error.to_string(),
        "y depends on u, which is not a variable of the model"
    );
}

#[test]
fn a_name_of_two_units_or_two_enumerations_is_refused() {
    const DIFFERENCE: Unit = Unit::new("K", Unit::KELVIN.exponents, &[]);
    static OTHER: Enumeration = Enumeration {
        name: "Mode",
        description: "",
        items: &[],
    };
    let real = |name, unit| Variable::input(name, unit, |m: &mut Sample| &mut m.speed, "");
    let choice =
        |name, kind| Variable::enumeration_input(name, kind, |m: &mut Sample| &mut m.mode, "");
    let units = |unit| super::units::definitions(&[real("a", Unit::KELVIN), real("b", unit)]);
    let types = |kind| super::types::definitions(&[choice("a", &MODE), choice("b", kind)]);
    assert!(units(Unit::KELVIN).is_ok() && types(&MODE).is_ok());
    let said = "of b is not the";
    for (error, start) in [
        (units(DIFFERENCE).err(), "unit K"),
        (types(&OTHER).err(), "enumeration Mode"),
    ] {
        let text = error.unwrap().to_string();
        assert!(text.starts_with(&format!("{start} {said}")), "{text}");
    }
}
