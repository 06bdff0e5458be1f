//! What the help of a command says below its options.

pub(crate) const CHECK: &str = "\
The code of an FMU runs in a process of its own: one that crashes, hangs or prints is reported. It may still
do to your files what you may; check only FMUs whose origin you know.

An error breaks FMI 2.0.4. A warning is legal, but some machine or user will stumble over it: libraries that
are not the system's, symbols that are not FMI's, search paths and file names of the machine it was built on,
glibc above 2.17, printing. `--strict` takes warnings for errors. In FMUs that this program packed, those of
symbols, libraries, paths and names always are errors; glibc and libgcc_s are what a build for one's own machine
may need.

Examples:
  cargo fmu check target/fmu/DctPlant.fmu
  cargo fmu check --strict --glibc 2.17 Supplier.fmu
  cargo fmu check --json target/fmu/*.fmu

Exit codes: 0 all are valid, 1 an FMU could not be checked, 2 usage, 3 an FMU is invalid.";

pub(crate) const BUILD: &str = "\
A target is one of rustc's, e.g. x86_64-pc-windows-gnullvm. One for Linux may have the oldest glibc behind it,
x86_64-unknown-linux-gnu.2.17: then cargo-zigbuild links it. Repeated, all go into one FMU.
A small library computes the same bits, in steps of up to a tenth more instructions. Its first build takes a minute
longer: the standard library is built, too, without what would print where a panic came from, which an FMU keeps
quiet about anyway.
Two builds of the same sources give the same bytes.
A package of your own needs a model, fmi2_cosim::export!(...) and a library of the types cdylib and lib; what it is
described from is built in its target folder. In a workspace of your own, --manifest-path can be left out.

Examples:
  cargo fmu build
  cargo fmu build --manifest-path ../tank/Cargo.toml
  cargo fmu build DctPlant --out /data --small
  cargo fmu build --target x86_64-unknown-linux-gnu.2.17 --target x86_64-pc-windows-gnullvm";

pub(crate) const REPLAY: &str = "\
Several FMUs are coupled: an input takes the output of its name from the FMU nearest before its own,
going round; they step in the order of the list.
The same file on two platforms means that both compute the same.

Example, of a file with the lines `time,engine.torque,clutch1.position`, `0,0,0` and `1,60,0.006`:
  cargo fmu replay --inputs step.csv --out outputs.csv target/fmu/DctPlant.fmu";

pub(crate) const MERGE: &str = "\
Their descriptions must be the same, GUID included.

Example:
  cargo fmu merge linux.fmu windows.fmu --out both.fmu";
