//! What `fmi2Instantiate` is asked for, and whether it is this FMU.

use crate::{Error, guid};
use core::ffi::{CStr, c_int};

/// `fmi2CoSimulation` of `fmi2Type`.
const CO_SIMULATION: c_int = 1;

/// Checks name, kind and GUID of an instance to be made; `own` is the library's GUID.
pub(crate) fn check(
    name: &CStr,
    kind: c_int,
    guid: Option<&CStr>,
    own: &guid::Text,
) -> Result<(), Error> {
    if name.is_empty() {
        return Err(Error::Instantiate("instanceName is NULL or empty"));
    }
    if kind != CO_SIMULATION {
        return Err(Error::Instantiate(
            "fmuType is not fmi2CoSimulation, the only type of this FMU",
        ));
    }
    let given = guid.ok_or(Error::Instantiate("fmuGUID is NULL"))?;
    if given.to_bytes() == own {
        Ok(())
    } else {
        Err(Error::Guid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_one_request_that_is_for_this_fmu_is_accepted() {
        let (own, text) = (c"{00000000-0000-0000-0000-00000000002a}", guid::text(42));
        let refused = [
            (c"", 1, Some(own)),
            (c"a", 0, Some(own)),
            (c"a", 1, None),
            (c"a", 1, Some(c"{00000000-0000-0000-0000-00000000002b}")),
            (c"a", 1, Some(c"{00000000-0000-0000-0000-0000000000002a}")),
            (c"a", 1, Some(c"{00000000-0000-0000-0000-00000000002A}")),
            (c"a", 1, Some(c"")),
        ];
        for (name, kind, guid) in refused {
            assert!(
                check(name, kind, guid, &text).is_err(),
                "{name:?} {kind} {guid:?}"
            );
        }
        assert_eq!(check(c"a", 1, Some(own), &text), Ok(()));
    }
}
