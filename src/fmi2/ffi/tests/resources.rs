//! A model that reads a file of its FMU.

use super::*;
use crate::{LoadError, Resources};
use std::fs;
use std::path::PathBuf;

/// y = u times the number in `factor.txt`.
#[derive(Clone, Default)]
struct Scaled {
    u: f64,
    y: f64,
    factor: f64,
}

impl Model for Scaled {
    const NAME: &'static str = "Scaled";
    const DESCRIPTION: &'static str = "An input times a number of a file";
    const EXPERIMENT: Experiment = Experiment::new(0.0, 1.0, 0.1);
    const RESOURCES: bool = true;
    const VARIABLES: &'static [Variable<Self>] = &[
        Variable::input("u", Unit::ONE, |m: &mut Self| &mut m.u, "Input"),
        Variable::output("y", Unit::ONE, |m: &mut Self| &mut m.y, "Output").depends_on(&["u"]),
    ];

    fn load(&mut self, resources: Option<&Resources>, log: &mut Log<'_>) -> Result<(), LoadError> {
        let resources = resources.ok_or("it needs its resources")?;
        let text = resources.text("factor.txt")?;
        assert!(text != "panic", "a fault of the model");
        self.factor = text.trim().parse()?;
        log.event(format_args!("factor {}", self.factor));
        Ok(())
    }

    fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.update_outputs();
        Ok(())
    }

    fn step(&mut self, _: f64, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.update_outputs();
        Ok(())
    }

    fn update_outputs(&mut self) {
        self.y = self.factor * self.u;
    }

    fn hidden_state(&mut self, _: &mut dyn StateFields) {}
}

static SCALED: Library<Scaled> = Library::empty();

/// A folder of a test with `factor.txt`, removed on drop.
struct Folder(PathBuf);

impl Folder {
    fn with(name: &str, factor: &str) -> Self {
        let path = std::env::temp_dir().join(format!("fmi2-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        fs::write(path.join("factor.txt"), factor).unwrap();
        Self(path)
    }

    fn uri(&self) -> CString {
        CString::new(format!("file://{}", self.0.display())).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn scaled(location: *const c_char) -> *mut c_void {
    instantiate_at(&SCALED, &guid::<Scaled>(), location, true)
}

/// Brings an instance to its first communication point with u = 2; the output there.
fn run(c: *mut c_void) -> f64 {
    let enter = |call, body: fn(&mut Instance<Scaled>, &mut Log<'_>) -> Result<(), Error>| {
        assert_eq!(SCALED.enter(c, call, body), Status::Ok, "{call}");
    };
    enter(Call::SetReal, |i, _| i.set(&[0], [2.0].into_iter()));
    enter(Call::EnterInitializationMode, |i, _| {
        i.enter_initialization()
    });
    enter(Call::ExitInitializationMode, |i, log| {
        i.exit_initialization(log)
    });
    assert_eq!(SCALED.step(c, 0.0, 0.5), Status::Ok);
    output(c)
}

fn output(c: *mut c_void) -> f64 {
    let mut y = f64::NAN;
    // SAFETY: one reference, one value.
    assert_eq!(unsafe { SCALED.get_reals(c, &1, 1, &mut y) }, Status::Ok);
    y
}

#[test]
fn what_was_loaded_is_there_after_a_reset_and_after_the_file_is_gone() {
    let folder = Folder::with("kept", "1.5\n");
    let c = scaled(folder.uri().as_ptr());
    assert!(!c.is_null());
    assert!(LINES.take().iter().any(|line| line.3 == "factor 1.5"));
    drop(folder);
    assert_eq!(run(c).to_bits(), 3.0_f64.to_bits());
    let reset = SCALED.enter(c, Call::Reset, |i, _| i.reset());
    assert_eq!(reset, Status::Ok);
    assert_eq!(run(c).to_bits(), 3.0_f64.to_bits());
    // SAFETY: one of ours.
    unsafe { SCALED.free_instance(c) };
}

#[test]
fn a_serialised_state_is_read_back_with_the_files_of_the_instance() {
    let (here, there) = (Folder::with("here", "1.5"), Folder::with("there", "10"));
    let (one, other) = (scaled(here.uri().as_ptr()), scaled(there.uri().as_ptr()));
    run(one);
    let (mut state, mut bytes, mut size) = (null_mut(), Vec::new(), 0);
    // SAFETY: pointers to what is there, of the sizes that are told.
    unsafe {
        assert_eq!(SCALED.get_state(one, &mut state), Status::Ok);
        assert_eq!(SCALED.state_size(one, state, &mut size), Status::Ok);
        bytes.resize(size, 0);
        let bytes = bytes.as_mut_ptr();
        assert_eq!(SCALED.serialize_state(one, state, bytes, size), Status::Ok);
        assert_eq!(
            SCALED.deserialize_state(other, bytes, size, &mut state),
            Status::Ok
        );
    }
    assert_eq!(SCALED.set_state(other, state), Status::Ok);
    assert_eq!(output(other).to_bits(), 3.0_f64.to_bits(), "a saved output");
    assert_eq!(SCALED.step(other, 0.5, 0.5), Status::Ok);
    assert_eq!(output(other).to_bits(), 20.0_f64.to_bits(), "its own file");
    for c in [one, other] {
        // SAFETY: one of ours.
        unsafe { SCALED.free_instance(c) };
    }
}

#[test]
fn an_importer_is_told_why_there_is_no_instance() {
    let (broken, panics) = (Folder::with("broken", "x"), Folder::with("panics", "panic"));
    let empty = Folder::with("empty", "");
    fs::remove_file(empty.0.join("factor.txt")).unwrap();
    let told = |location: *const c_char| {
        LINES.take();
        assert!(scaled(location).is_null());
        LINES.take().pop().map(|line| line.3).unwrap_or_default()
    };
    assert_eq!(told(null()), "fmi2Instantiate: it needs its resources");
    assert_eq!(
        told(c"".as_ptr()),
        "fmi2Instantiate: it needs its resources"
    );
    assert_eq!(
        told(c"http://x/y".as_ptr()),
        "fmi2Instantiate: fmuResourceLocation = http://x/y: neither a file: URI nor an absolute path"
    );
    assert!(told(c"file:///no/such".as_ptr()).ends_with("/no/such is no folder"));
    assert_eq!(
        told(broken.uri().as_ptr()),
        "fmi2Instantiate: invalid float literal"
    );
    assert!(told(empty.uri().as_ptr()).starts_with("fmi2Instantiate: resources/factor.txt: "));
    assert_eq!(
        told(panics.uri().as_ptr()),
        "fmi2Instantiate: the model panicked"
    );
    let endless = [b"file:///".to_vec(), vec![b'%'; 1 << 20]].concat();
    let endless = CString::new(endless).unwrap();
    assert!(told(endless.as_ptr()).starts_with("fmi2Instantiate: fmuResourceLocation = file:///%"));
}
