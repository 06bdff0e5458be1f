//! Life cycle: the states of an instance, and which call is legal in which, as one table.
//!
//! FMI 2.0.4, 4.2.4. The states `stepInProgress` and `stepCanceled` are missing because `fmi2DoStep` never returns
//! `fmi2Pending`, and `stepFailed` because a step that it discards has changed nothing: that is `stepComplete`.

use core::fmt;

/// Where an instance stands in its life cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Made; start values may be set.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization,
    /// At a communication point.
    StepComplete,
    /// After `fmi2Terminate`.
    Terminated,
    /// The model failed; only reset, restoring a state or freeing lead out.
    Error,
}

impl State {
    /// All states; the position is the number written in serialised states.
    pub const ALL: [Self; 5] = [
        Self::Instantiated,
        Self::Initialization,
        Self::StepComplete,
        Self::Terminated,
        Self::Error,
    ];
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Instantiated => "instantiated",
            Self::Initialization => "initializationMode",
            Self::StepComplete => "stepComplete",
            Self::Terminated => "terminated",
            Self::Error => "error",
        })
    }
}

macro_rules! calls {
    ($($call:ident: $states:expr;)*) => {
        /// The functions whose legality depends on the state; named as in FMI without `fmi2`.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Call { $(#[doc = concat!("`fmi2", stringify!($call), "`.")] $call,)* }

        impl Call {
            /// Every call.
            pub const ALL: &'static [Self] = &[$(Self::$call,)*];

            /// The states in which it is legal.
            #[must_use]
            pub const fn legal(self) -> &'static [State] {
                match self { $(Self::$call => $states,)* }
            }
        }

        impl fmt::Display for Call {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(match self { $(Self::$call => concat!("fmi2", stringify!($call)),)* })
            }
        }
    };
}

use State::{Error, Initialization, Instantiated, StepComplete, Terminated};

const ANY: &[State] = &State::ALL;
const SETTERS: &[State] = &[Instantiated, Initialization, StepComplete];
const RESULTS: &[State] = &[StepComplete, Terminated, Error];
const REPORTS: &[State] = &[StepComplete, Terminated];

calls! {
    SetDebugLogging: ANY;
    SetupExperiment: &[Instantiated];
    EnterInitializationMode: &[Instantiated];
    ExitInitializationMode: &[Initialization];
    Terminate: &[StepComplete];
    Reset: ANY;
    // The standard has no getter in `instantiated`; importers read start values there.
    GetReal: ANY;
    GetInteger: ANY;
    GetBoolean: ANY;
    GetString: ANY;
    SetReal: SETTERS;
    SetInteger: SETTERS;
    SetBoolean: SETTERS;
    SetString: SETTERS;
    GetFMUstate: ANY;
    SetFMUstate: ANY;
    FreeFMUstate: ANY;
    SerializedFMUstateSize: ANY;
    SerializeFMUstate: ANY;
    DeSerializeFMUstate: ANY;
    GetDirectionalDerivative: &[Initialization, StepComplete, Terminated, Error];
    SetRealInputDerivatives: SETTERS;
    GetRealOutputDerivatives: RESULTS;
    DoStep: &[StepComplete];
    CancelStep: &[];
    GetStatus: REPORTS;
    GetRealStatus: REPORTS;
    GetIntegerStatus: REPORTS;
    GetBooleanStatus: REPORTS;
    GetStringStatus: REPORTS;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where importers do what the standard leaves out.
    const DEPARTURES: [(&str, State); 4] = [
        ("fmi2GetReal", Instantiated),
        ("fmi2GetInteger", Instantiated),
        ("fmi2GetBoolean", Instantiated),
        ("fmi2GetString", Instantiated),
    ];

    /// Functions whose legality does not depend on the state of an instance.
    const OUTSIDE: [&str; 4] = [
        "fmi2GetTypesPlatform",
        "fmi2GetVersion",
        "fmi2Instantiate",
        "fmi2FreeInstance",
    ];

    #[test]
    fn calls_are_legal_where_the_standard_says_and_where_importers_read_start_values() {
        for call in Call::ALL {
            let name = call.to_string();
            for state in State::ALL {
                let expected = standard::allows(&name, &state.to_string())
                    || DEPARTURES.contains(&(name.as_str(), state));
                assert_eq!(call.legal().contains(&state), expected, "{name} in {state}");
            }
        }
        let known = Call::ALL.iter().map(ToString::to_string);
        let mut known: Vec<_> = known.chain(OUTSIDE.map(String::from)).collect();
        let mut listed = standard::functions();
        known.sort();
        listed.sort();
        assert_eq!(known, listed);
    }
}

/// The table of FMI 2.0.4, 4.2.4, as data: `legal_calls.csv`.
#[cfg(test)]
pub(crate) mod standard {
    const TABLE: &str = include_str!("legal_calls.csv");

    fn rows() -> impl Iterator<Item = Vec<&'static str>> {
        let lines = TABLE.lines().filter(|line| !line.starts_with('#'));
        lines.map(|line| line.split(',').collect())
    }

    pub(crate) fn functions() -> Vec<String> {
        rows().skip(1).map(|row| row[0].to_owned()).collect()
    }

    /// Whether a function may be called in a state, under a note or without one.
    pub(crate) fn allows(function: &str, state: &str) -> bool {
        let header = rows().next().unwrap();
        let column = header.iter().position(|name| *name == state).unwrap();
        let row = rows().find(|row| row[0] == function).unwrap();
        !row[column].is_empty()
    }
}
