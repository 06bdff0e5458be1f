//! Life cycle: the states of an instance, and which call is legal in which, as one table.
//!
//! FMI 2.0.4, 4.2.4. The states `stepInProgress`, `stepFailed` and `stepCanceled` are missing
//! because `fmi2DoStep` never returns `fmi2Pending` or `fmi2Discard`.

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
        #[allow(missing_docs)] // the names are those of the standard
        pub enum Call { $($call,)* }

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

    /// Table of FMI 2.0.4, 4.2.4, typed from the standard: one column per state, in the order of
    /// [`State::ALL`]. Calls under a note (certain variables only, values for debugging) are `x`.
    const STANDARD: [(&str, &str); 30] = [
        ("fmi2SetDebugLogging", "xxxxx"),
        ("fmi2SetupExperiment", "x...."),
        ("fmi2EnterInitializationMode", "x...."),
        ("fmi2ExitInitializationMode", ".x..."),
        ("fmi2Terminate", "..x.."),
        ("fmi2Reset", "xxxxx"),
        ("fmi2GetReal", ".xxxx"),
        ("fmi2GetInteger", ".xxxx"),
        ("fmi2GetBoolean", ".xxxx"),
        ("fmi2GetString", ".xxxx"),
        ("fmi2SetReal", "xxx.."),
        ("fmi2SetInteger", "xxx.."),
        ("fmi2SetBoolean", "xxx.."),
        ("fmi2SetString", "xxx.."),
        ("fmi2GetFMUstate", "xxxxx"),
        ("fmi2SetFMUstate", "xxxxx"),
        ("fmi2FreeFMUstate", "xxxxx"),
        ("fmi2SerializedFMUstateSize", "xxxxx"),
        ("fmi2SerializeFMUstate", "xxxxx"),
        ("fmi2DeSerializeFMUstate", "xxxxx"),
        ("fmi2GetDirectionalDerivative", ".xxxx"),
        ("fmi2SetRealInputDerivatives", "xxx.."),
        ("fmi2GetRealOutputDerivatives", "..xxx"),
        ("fmi2DoStep", "..x.."),
        ("fmi2CancelStep", "....."),
        ("fmi2GetStatus", "..xx."),
        ("fmi2GetRealStatus", "..xx."),
        ("fmi2GetIntegerStatus", "..xx."),
        ("fmi2GetBooleanStatus", "..xx."),
        ("fmi2GetStringStatus", "..xx."),
    ];

    /// Where importers do what the standard leaves out.
    const DEPARTURES: [(&str, State); 4] = [
        ("fmi2GetReal", Instantiated),
        ("fmi2GetInteger", Instantiated),
        ("fmi2GetBoolean", Instantiated),
        ("fmi2GetString", Instantiated),
    ];

    #[test]
    fn calls_are_legal_where_the_standard_says_and_where_importers_read_start_values() {
        assert_eq!(Call::ALL.len(), STANDARD.len());
        for (name, columns) in STANDARD {
            let call = Call::ALL.iter().find(|call| call.to_string() == name);
            let call = call.expect(name);
            for (state, column) in State::ALL.into_iter().zip(columns.chars()) {
                let expected = column == 'x' || DEPARTURES.contains(&(name, state));
                assert_eq!(call.legal().contains(&state), expected, "{name} in {state}");
            }
        }
    }
}
