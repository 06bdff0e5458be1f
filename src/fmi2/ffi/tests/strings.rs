//! Strings at the C boundary: what is set is read, kept in states, and refused when it is no text.

use super::*;

/// Greets whom it is told to, and remembers whom it greeted last.
#[derive(Clone)]
struct Host {
    greeting: String,
    guest: String,
    says: String,
    last: String,
    real: f64,
}

impl Default for Host {
    fn default() -> Self {
        let [guest, says, last] = [const { String::new() }; 3];
        let greeting = "Hello".into();
        Self {
            greeting,
            guest,
            says,
            last,
            real: 0.0,
        }
    }
}

const GREETING: u32 = 0;
const GUEST: u32 = 1;
const SAYS: u32 = 2;
const LAST: u32 = 3;
const REAL: u32 = 4;

impl Model for Host {
    const NAME: &'static str = "Host";
    const DESCRIPTION: &'static str = "";
    const EXPERIMENT: Experiment = Experiment::new(0.0, 1.0, 0.1);
    const VARIABLES: &'static [Variable<Self>] = &[
        Variable::string_parameter("greeting", |m: &mut Self| &mut m.greeting, ""),
        Variable::string_input("guest", |m: &mut Self| &mut m.guest, ""),
        Variable::string_output("says", |m: &mut Self| &mut m.says, "").depends_on(&["guest"]),
        Variable::string_output("last", |m: &mut Self| &mut m.last, "").depends_on(&[]),
        Variable::input("real", Unit::ONE, |m: &mut Self| &mut m.real, ""),
    ];

    fn initialize(&mut self, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.last.clear();
        self.update_outputs();
        Ok(())
    }

    fn step(&mut self, _: f64, _: f64, _: &mut Log<'_>) -> Result<(), Failure> {
        self.last.clone_from(&self.guest);
        self.update_outputs();
        Ok(())
    }

    fn update_outputs(&mut self) {
        self.says = format!("{}, {}", self.greeting, self.guest);
    }

    fn hidden_state(&mut self, fields: &mut dyn StateFields) {
        fields.text(&mut self.last);
    }
}

static HOSTS: Library<Host> = Library::empty();

/// An instance that is freed at the end.
struct One(*mut c_void);

impl Drop for One {
    fn drop(&mut self) {
        // SAFETY: a live component.
        unsafe { HOSTS.free_instance(self.0) }
    }
}

fn host() -> One {
    LINES.take();
    One(instantiate_in(&HOSTS, &guid::<Host>(), true))
}

impl One {
    fn start(self) -> Self {
        let entered = HOSTS.enter(self.0, Call::EnterInitializationMode, |i, _| {
            i.enter_initialization()
        });
        let left = HOSTS.enter(self.0, Call::ExitInitializationMode, |i, log| {
            i.exit_initialization(log)
        });
        assert_eq!([entered, left], [Status::Ok; 2]);
        self
    }

    fn step(&self, time: f64) {
        assert_eq!(HOSTS.step(self.0, time, 0.1), Status::Ok);
    }

    fn set(&self, references: &[u32], texts: &[&CStr]) -> Status {
        let texts: Vec<_> = texts.iter().map(|text| text.as_ptr()).collect();
        // SAFETY: a live component; arrays of that length.
        unsafe {
            HOSTS.set_strings(
                self.0,
                references.as_ptr(),
                references.len(),
                texts.as_ptr(),
            )
        }
    }

    fn get(&self, references: &[u32]) -> Result<Vec<String>, Status> {
        let mut texts = vec![null(); references.len()];
        let (count, to) = (references.len(), texts.as_mut_ptr());
        // SAFETY: a live component; arrays of that length.
        let status = unsafe { HOSTS.get_strings(self.0, references.as_ptr(), count, to) };
        if status != Status::Ok {
            assert!(
                texts.iter().all(|text| text.is_null()),
                "a refused getter wrote"
            );
            return Err(status);
        }
        // SAFETY: strings that the instance keeps until it is asked again.
        let owned = |pointer| unsafe { text(pointer) }.unwrap().to_str().unwrap().into();
        Ok(texts.into_iter().map(owned).collect())
    }

    fn save(&self) -> Vec<u8> {
        let (mut state, mut size) = (null_mut(), 0);
        // SAFETY: a live component; places of our own; as many bytes as the state has.
        unsafe {
            assert_eq!(HOSTS.get_state(self.0, &mut state), Status::Ok);
            assert_eq!(HOSTS.state_size(self.0, state, &mut size), Status::Ok);
            let mut bytes = vec![0; size];
            let written = HOSTS.serialize_state(self.0, state, bytes.as_mut_ptr(), size);
            assert_eq!(written, Status::Ok);
            assert_eq!(HOSTS.free_state(self.0, &mut state), Status::Ok);
            bytes
        }
    }

    fn restore(&self, bytes: &[u8]) -> Status {
        let mut state = null_mut();
        // SAFETY: a live component; bytes of that number; a place of our own.
        unsafe {
            let read = HOSTS.deserialize_state(self.0, bytes.as_ptr(), bytes.len(), &mut state);
            if read == Status::Ok {
                assert_eq!(HOSTS.set_state(self.0, state), Status::Ok);
                assert_eq!(HOSTS.free_state(self.0, &mut state), Status::Ok);
            }
            read
        }
    }
}

#[test]
fn strings_are_set_and_read_several_at_once() {
    let host = host();
    assert_eq!(host.get(&[GREETING]), Ok(vec!["Hello".into()]));
    assert_eq!(host.set(&[GREETING], &[c"Gr\u{fc}\u{df} Gott"]), Status::Ok);
    let host = host.start();
    assert_eq!(host.set(&[GUEST], &[c"Ada"]), Status::Ok);
    let said = ["Ada", "Gr\u{fc}\u{df} Gott, Ada", ""].map(String::from);
    assert_eq!(host.get(&[GUEST, SAYS, LAST]), Ok(said.into()));
    host.step(0.0);
    assert_eq!(host.get(&[LAST, LAST]), Ok(vec!["Ada".into(); 2]));
    assert_eq!(host.get(&[]), Ok(Vec::new()));
}

#[test]
fn what_is_refused_changes_nothing_and_is_told() {
    let host = host().start();
    assert_eq!(host.set(&[GUEST], &[c"Ada"]), Status::Ok);
    let refused: [(&[u32], &[&CStr], Status, &str); 6] = [
        (
            &[GUEST, SAYS],
            &[c"Bo", c""],
            Status::Error,
            "says may not be set in state stepComplete: the model computes it; set what it depends on",
        ),
        (
            &[GUEST, GREETING],
            &[c"Bo", c""],
            Status::Error,
            "greeting may not be set in state stepComplete: it is a fixed parameter; set it before initialisation ends",
        ),
        (
            &[GUEST, REAL],
            &[c"Bo", c""],
            Status::Error,
            "value reference 4 is no String variable",
        ),
        (
            &[GUEST, 9],
            &[c"Bo", c""],
            Status::Error,
            "value reference 9 is no String variable",
        ),
        (
            &[GUEST, GUEST],
            &[c"Bo", c"Cy"],
            Status::Error,
            "guest is set twice in one call",
        ),
        (
            &[GUEST],
            &[c"\xff"],
            Status::Discard,
            "argument value holds a text that is not UTF-8",
        ),
    ];
    for (references, texts, status, said) in refused {
        LINES.take();
        assert_eq!(host.set(references, texts), status, "{said}");
        let [(.., line)] = &LINES.take()[..] else {
            panic!("not one line for: {said}");
        };
        assert!(
            line.starts_with(&format!("fmi2SetString: {said}")),
            "{line}"
        );
        assert_eq!(host.get(&[GUEST]), Ok(vec!["Ada".into()]));
    }
    let texts = [null()];
    // SAFETY: a live component; arrays of one.
    let nothing = unsafe { HOSTS.set_strings(host.0, &GUEST, 1, texts.as_ptr()) };
    assert_eq!(nothing, Status::Error);
    assert_eq!(host.get(&[REAL]), Err(Status::Error));
}

#[test]
fn a_nul_within_a_text_of_the_model_is_left_out() {
    let host = host();
    let set = HOSTS.enter(host.0, Call::SetString, |i, _| {
        i.set_strings(&[GREETING], &["Good\0 day"])
    });
    assert_eq!(set, Status::Ok);
    assert_eq!(host.get(&[GREETING]), Ok(vec!["Good day".into()]));
}

#[test]
fn states_hold_texts_of_any_length() {
    let (host, other) = (host().start(), host());
    let long = CString::new("x".repeat(10_000)).unwrap();
    let mut time = 0.0;
    for name in [c"", c"Ada", &long] {
        assert_eq!(host.set(&[GUEST], &[name]), Status::Ok);
        host.step(time);
        time += 0.1;
        assert_eq!(other.restore(&host.save()), Status::Ok);
        let all = [GREETING, GUEST, SAYS, LAST];
        assert_eq!(other.get(&all), host.get(&all));
        assert_eq!(other.save(), host.save());
    }
}

#[test]
fn damaged_texts_of_states_are_refused() {
    let host = host().start();
    let bytes = host.save();
    let least = bytes.len() - 2 * "Hello".len() - ", ".len();
    for size in [0, 1, least - 1, least, bytes.len() - 1] {
        assert_eq!(host.restore(&bytes[..size]), Status::Error, "{size}");
    }
    let longer = [&bytes[..], &[0]].concat();
    assert_eq!(host.restore(&longer), Status::Error);
    for bit in 0..8 * bytes.len() {
        let mut damaged = bytes.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(host.restore(&damaged), Status::Error, "bit {bit}");
    }
    assert_eq!(host.get(&[SAYS]), Ok(vec!["Hello, ".into()]));
}
