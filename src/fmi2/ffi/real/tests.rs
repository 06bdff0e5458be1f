use super::{ARMS, get, get_others, set};
use crate::saved::Saved;
use crate::{Experiment, Failure, Log, Model, StateFields, Unit, Variable};

/// Reals in the model and outside of it, of every role.
#[derive(Clone)]
struct Shelf {
    near: [f64; 200],
    far: Box<f64>,
    count: i32,
    flag: bool,
    far_flag: Box<bool>,
    asked: bool,
}

impl Default for Shelf {
    fn default() -> Self {
        let near = core::array::from_fn(|index| f64::from(u8::try_from(index).unwrap()));
        Self {
            near,
            far: Box::new(-1.0),
            count: 0,
            flag: false,
            far_flag: Box::default(),
            asked: false,
        }
    }
}

/// Leads to a flag in the model and to one outside of it in turns.
fn fickle(shelf: &mut Shelf) -> &mut bool {
    shelf.asked = !shelf.asked;
    if shelf.asked {
        &mut shelf.flag
    } else {
        &mut shelf.far_flag
    }
}

const fn near<const K: usize>() -> Variable<Shelf> {
    Variable::input("near", Unit::ONE, |m: &mut Shelf| &mut m.near[K], "")
}

const INPUT: u32 = 0;
const TUNABLE: u32 = 1;
const FIXED: u32 = 2;
const OUTPUT: u32 = 3;
const INTEGER: u32 = 4;
const FAR: u32 = 5;
const FREE: u32 = 6;
const FLAG: u32 = 7;
const FAR_FLAG: u32 = 8;
const FICKLE: u32 = 9;
const ONE_OF_MANY: u32 = 24; // shares its bit with INPUT
const LAST: u32 = ARMS - 1;
const BEYOND: u32 = ARMS;

impl Model for Shelf {
    const NAME: &'static str = "Shelf";
    const DESCRIPTION: &'static str = "";
    const EXPERIMENT: Experiment = Experiment {
        start: 0.0,
        stop: 1.0,
        step: 0.1,
    };
    const VARIABLES: &'static [Variable<Self>] = &{
        let mut rows = [near::<150>(); 260];
        rows[0] = near::<0>().min(-1.0).max(2.0);
        rows[1] = Variable::parameter("", Unit::ONE, |m: &mut Self| &mut m.near[1], "").tunable();
        rows[2] = Variable::parameter("", Unit::ONE, |m: &mut Self| &mut m.near[2], "");
        rows[3] = Variable::output("", Unit::ONE, |m: &mut Self| &mut m.near[3], "");
        rows[4] = Variable::integer_input("", |m: &mut Self| &mut m.count, "");
        rows[5] = Variable::input("", Unit::ONE, |m: &mut Self| &mut m.far, "");
        rows[6] = near::<4>();
        rows[7] = Variable::boolean_input("", |m: &mut Self| &mut m.flag, "");
        rows[8] = Variable::boolean_input("", |m: &mut Self| &mut m.far_flag, "");
        rows[9] = Variable::boolean_input("", fickle, "");
        rows
    };

    fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        Ok(())
    }

    fn step(&mut self, _: f64, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        Ok(())
    }

    fn hidden_state(&mut self, _: &mut dyn StateFields) {}
}

#[test]
fn a_reference_leads_to_the_field_of_its_row() {
    let mut shelf = Saved::<Shelf>::new();
    let references = [INPUT, FREE, OUTPUT, ONE_OF_MANY, LAST];
    let mut values = [f64::NAN; 5];
    assert!(get(&mut shelf, &mut false, &references, &mut values));
    assert_eq!(values, [0.0, 4.0, 3.0, 150.0, 150.0]);
    assert!(set(&mut shelf, &[FREE, LAST], &[-0.5, 7.0]));
    assert_eq!(shelf.model.near[..5], [0.0, 1.0, 2.0, 3.0, -0.5]);
    assert_eq!(shelf.model.near[150], 7.0);
}

/// Reals are read four at a time, and the rest one by one.
#[test]
fn one_reference_that_is_none_is_seen_wherever_it_stands() {
    let mut shelf = Saved::<Shelf>::new();
    for count in 1..18 {
        let mut values = [f64::NAN; 20];
        let all = [[INPUT, FREE, OUTPUT, LAST]; 5].concat();
        let mut read = |references: &[u32]| {
            let values = &mut values[..count];
            get(&mut shelf, &mut false, references, values).then(|| values.to_vec())
        };
        let expected = [[0.0, 4.0, 3.0, 150.0]; 5].concat();
        assert_eq!(read(&all[..count]).as_deref(), Some(&expected[..count]));
        for place in 0..count {
            for none in [FIXED, INTEGER, FAR, BEYOND, u32::MAX] {
                let mut references = all[..count].to_vec();
                references[place] = none;
                assert_eq!(read(&references), None, "{none} at {place} of {count}");
            }
        }
    }
}

#[test]
fn what_is_no_real_in_the_model_itself_goes_the_ordinary_way() {
    let mut shelf = Saved::<Shelf>::new();
    let mut values = [f64::NAN; 2];
    for reference in [
        TUNABLE,
        FIXED,
        INTEGER,
        FAR,
        BEYOND,
        BEYOND + 1,
        BEYOND + 2,
        u32::MAX,
    ] {
        for references in [[INPUT, reference], [reference, INPUT]] {
            let read = get(&mut shelf, &mut false, &references, &mut values);
            assert!(!read, "{reference}");
            assert!(!set(&mut shelf, &references, &[1.0; 2]), "{reference}");
        }
    }
    let Shelf {
        near, far, count, ..
    } = shelf.model;
    assert_eq!((near[0], *far, count), (0.0, -1.0, 0));
}

#[test]
fn a_count_or_a_flag_is_read_where_all_that_is_asked_for_is_one() {
    let mut shelf = Saved::<Shelf>::new();
    (shelf.model.count, shelf.model.flag) = (-5, true);
    let (mut counts, mut flags) = ([0; 2], [0; 2]);
    assert!(get_others::<_, i32, i32>(
        &mut shelf,
        &[INTEGER; 2],
        &mut counts
    ));
    assert!(get_others::<_, bool, i32>(
        &mut shelf, &[FLAG; 2], &mut flags
    ));
    assert_eq!((counts, flags), ([-5; 2], [1; 2]));
    for other in [
        INPUT,
        OUTPUT,
        FAR,
        FAR_FLAG,
        LAST,
        BEYOND,
        BEYOND + INTEGER,
        u32::MAX,
    ] {
        let (mut counts, mut flags) = ([0; 2], [0; 2]);
        assert!(!get_others::<_, i32, i32>(
            &mut shelf,
            &[INTEGER, other],
            &mut counts
        ));
        assert!(!get_others::<_, bool, i32>(
            &mut shelf,
            &[other, FLAG],
            &mut flags
        ));
    }
    assert!(!get_others::<_, i32, i32>(&mut shelf, &[FLAG], &mut counts));
    assert!(!get_others::<_, bool, i32>(
        &mut shelf,
        &[INTEGER],
        &mut flags
    ));
}

/// An accessor that leads elsewhere when it is asked again costs a wrong answer, but no Boolean is neither 0 nor 1.
#[test]
fn a_place_that_is_gone_when_it_is_read_is_still_a_boolean() {
    let mut shelf = Saved::<Shelf>::new();
    shelf.time = f64::from_bits(2);
    let mut flags = [7];
    assert!(get_others::<_, bool, i32>(
        &mut shelf,
        &[FICKLE],
        &mut flags
    ));
    assert_eq!(flags, [1]);
}

/// Whether it is plain to set these; if it is not, nothing changes.
fn plain(references: &[u32], values: &[f64]) -> bool {
    let mut shelf = Saved::<Shelf>::new();
    let before = shelf.model.near;
    let plain = set(&mut shelf, references, values);
    assert!(plain || shelf.model.near == before);
    plain
}

#[test]
fn inputs_are_plain_to_set() {
    for (reference, expected) in [
        (INPUT, true),
        (FREE, true),
        (TUNABLE, false),
        (FIXED, false),
        (OUTPUT, false),
    ] {
        assert_eq!(plain(&[reference], &[0.5]), expected, "{reference}");
        assert_eq!(
            plain(&[LAST, reference], &[0.5; 2]),
            expected,
            "{reference}"
        );
    }
}

#[test]
fn values_that_are_not_finite_or_out_of_range_and_repetitions_need_a_second_look() {
    for (value, expected) in [(-1.0, true), (2.0, true), (-1.1, false), (2.1, false)] {
        assert_eq!(plain(&[INPUT], &[value]), expected, "{value}");
    }
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(!plain(&[INPUT], &[value]));
        assert!(!plain(&[LAST, FREE], &[0.0, value]));
        assert!(!plain(&[FREE], &[value]));
    }
    assert!(plain(&[FREE], &[f64::MAX]));
    for twice in [[INPUT, INPUT], [FREE, FREE], [INPUT, ONE_OF_MANY]] {
        assert!(!plain(&twice, &[0.0; 2]));
    }
    for reference in [FREE, OUTPUT, FAR] {
        let many = [reference; super::OWN as usize];
        assert!((2..=many.len()).all(|count| !plain(&many[..count], &[0.0; 24][..count])));
    }
}
