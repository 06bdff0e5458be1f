//! Constants, on a stone that falls under one, or under what a model should not have done to it.

use super::Instance;
use crate::saved::Saved;
use crate::{Alias, Error, Experiment, Failure, Log, Model, State, StateFields, Unit, Variable};

#[derive(Clone)]
struct Stone {
    gravity: f64,
    mass: f64,
    weight: f64,
    material: String,
}

impl Default for Stone {
    fn default() -> Self {
        Self {
            gravity: 9.81,
            mass: 1.0,
            weight: 0.0,
            material: "granite".into(),
        }
    }
}

const GRAVITY: u32 = 0;
const MASS: u32 = 1;
const WEIGHT: u32 = 2;
const MATERIAL: u32 = 3;

impl Model for Stone {
    const NAME: &'static str = "Stone";
    const DESCRIPTION: &'static str = "";
    const EXPERIMENT: Experiment = Experiment::new(0.0, 1.0, 0.1);
    const VARIABLES: &'static [Variable<Self>] = &[
        Variable::output("gravity", Unit::ONE, |m: &mut Self| &mut m.gravity, "")
            .constant()
            .aliases(&[Alias::local("g", "")]),
        Variable::input("mass", Unit::ONE, |m: &mut Self| &mut m.mass, ""),
        Variable::output("weight", Unit::ONE, |m: &mut Self| &mut m.weight, "")
            .depends_on(&["mass"]),
        Variable::string_output("material", |m: &mut Self| &mut m.material, "")
            .local()
            .constant(),
    ];

    fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.update_outputs();
        let light = Failure::Other("a stone weighs something");
        if self.weight > 0.0 {
            Ok(())
        } else {
            Err(light)
        }
    }

    fn step(&mut self, _: f64, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.update_outputs();
        Ok(())
    }

    fn update_outputs(&mut self) {
        self.weight = self.gravity * self.mass;
    }

    fn hidden_state(&mut self, _: &mut dyn StateFields) {}
}

fn silent<T>(act: impl FnOnce(&mut Log<'_>) -> T) -> T {
    act(&mut Log::new(&mut |_, _| ()))
}

fn read(stone: &mut Instance<Stone>, reference: u32) -> Result<f64, Error> {
    silent(|log| Ok(stone.get(&[reference], log)?.next().unwrap()))
}

/// A stone at its first communication point.
fn lying() -> Instance<Stone> {
    let mut stone = Instance::default();
    stone.enter_initialization().unwrap();
    silent(|log| stone.exit_initialization(log)).unwrap();
    stone
}

#[test]
fn it_is_read_in_every_state_without_computing_anything() {
    let mut stone = Instance::<Stone>::default();
    stone.set(&[MASS], [0.0].into_iter()).unwrap();
    assert_eq!(read(&mut stone, GRAVITY), Ok(9.81));
    stone.enter_initialization().unwrap();
    assert_eq!(read(&mut stone, GRAVITY), Ok(9.81));
    let texts = silent(|log| stone.strings(&[MATERIAL], log).map(Vec::from_iter));
    assert_eq!(texts, Ok(vec!["granite".into()]));
    assert_eq!(stone.state(), State::Initialization);
    assert!(read(&mut stone, WEIGHT).is_err());
    assert_eq!(stone.state(), State::Error);
    assert_eq!(read(&mut stone, GRAVITY), Ok(9.81));
    let mut stone = lying();
    assert_eq!(read(&mut stone, GRAVITY), Ok(9.81));
    stone.terminate().unwrap();
    assert_eq!(read(&mut stone, GRAVITY), Ok(9.81));
}

#[test]
fn it_is_never_set() {
    let mut initializing = Instance::<Stone>::default();
    initializing.enter_initialization().unwrap();
    for mut stone in [Instance::default(), initializing, lying()] {
        let state = stone.state();
        assert!(!stone.set_plainly(&[GRAVITY], &[1.62]));
        let refused = stone.set(&[GRAVITY], [1.62].into_iter());
        let told = |variable: &str| {
            format!("{variable} may not be set in state {state}: it is a constant")
        };
        assert_eq!(refused.unwrap_err().to_string(), told("gravity"));
        let refused = stone.set_strings(&[MATERIAL], &["basalt"]);
        assert_eq!(refused.unwrap_err().to_string(), told("material"));
        assert_eq!(read(&mut stone, GRAVITY), Ok(9.81));
    }
}

#[test]
fn it_is_no_part_of_a_serialised_state() {
    let mut stone = lying();
    let bytes = stone.save().unwrap().to_bytes();
    stone.now.model.gravity = 1.62;
    stone.now.model.material = "basalt".into();
    assert_eq!(stone.save().unwrap().to_bytes(), bytes);
    let read_back = Saved::<Stone>::from_bytes(&bytes).unwrap();
    assert_eq!(read_back.model.gravity, 9.81);
    assert_eq!(read_back.model.material, "granite");
}

#[test]
fn its_other_name_is_no_row_of_the_library() {
    let mut stone = lying();
    let reference = u32::try_from(Stone::VARIABLES.len()).unwrap();
    let kind = "Real";
    let unknown = Error::UnknownReference { reference, kind };
    assert_eq!(read(&mut stone, reference), Err(unknown));
}
