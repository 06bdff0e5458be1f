//! One run while it is made, as others see it: they can tell of it when an FMU never returns.

use crate::error::Error;
use crate::fmu::said;
use crate::outcome::{Outcome, Told};
use crate::plan::Plan;
use crate::recorder::{Seen, open};
use cosim_raw::{Calls, Log};
use std::sync::{Arc, Mutex, OnceLock};

/// The calls, messages and rows of a run so far.
#[derive(Default)]
pub struct Live {
    calls: Arc<Calls>,
    logs: OnceLock<Vec<(String, Arc<Log>)>>,
    pub(crate) seen: Mutex<Seen>,
}

impl Live {
    /// The logs of the components of a plan, in its order.
    pub(crate) fn begin(&self, plan: &Plan) -> Vec<Arc<Log>> {
        let numbered = plan.components.iter().zip(0..);
        let logs = numbered.map(|(component, number)| {
            let log = Log::new(self.calls.clone(), number, plan.log);
            (component.name.clone(), Arc::new(log))
        });
        let logs = self.logs.get_or_init(|| logs.collect());
        logs.iter().map(|(_, log)| log.clone()).collect()
    }

    /// Messages of each FMU so far.
    pub(crate) fn log(&self) -> Told {
        let logs = self.logs.get().map(Vec::as_slice).unwrap_or_default();
        let told = logs
            .iter()
            .map(|(name, log)| (name.clone(), log.messages()));
        told.collect()
    }

    /// What came of a run over `times` [s] that does not return, with `why` it is not waited for: its rows, and the
    /// FMU and call that it is in.
    pub fn stuck(&self, times: &[f64], why: &str) -> Outcome {
        let mut seen = open(&self.seen);
        let Seen { names, rows, good } = std::mem::take(&mut *seen);
        let time = times.get(good.saturating_sub(1)).copied();
        Outcome {
            error: Some(self.waits(time.unwrap_or_default(), why)),
            rows: rows.into_iter().take(good * names.len()).collect(),
            names,
            log: self.log(),
        }
    }

    fn waits(&self, time: f64, why: &str) -> Error {
        let (number, function) = self.calls.last().unwrap_or((0, "its first call"));
        let log = self.logs.get().and_then(|logs| logs.get(number));
        let (name, said) = log.map_or(("an FMU", String::new()), |(name, log)| (name, said(log)));
        Error::Stuck {
            component: name.to_owned(),
            function,
            time,
            what: format!("{why}{said}"),
        }
    }
}
