//! The processors that are measured, and how QEMU plays them.

use anyhow::{Result, bail};

use crate::package::Package;
use crate::setup::Emulator;
use crate::toolchain::Target;

/// A processor.
#[derive(Clone, Copy, Debug)]
pub struct Processor {
    /// Short name, for the command line.
    pub id: &'static str,
    /// Name.
    pub name: &'static str,
    /// Its firmware.
    pub package: Package,
    /// The emulator, and its machine with what it needs.
    pub emulator: Emulator,
    pub machine: &'static [&'static str],
    /// Where the frames lie, as in the board's memory map.
    pub frames: u32,
    /// The model of its cycles in the counting plugin.
    pub model: &'static str,
    /// Which of the goals are its.
    pub class: Class,
}

/// Processors with common goals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// M4F, M7, M33 with the DSP extension.
    Dsp,
    /// M33 without it: no goals of its own.
    Plain,
    /// M0+.
    Small,
    /// RV32IMC.
    Riscv,
}

const PACKAGE: Package = Package {
    name: "concentric-bench",
    folder: "examples/bench",
    target: Target::Armv7Em,
    cpu: None,
    features: &[],
};
const M4F: Processor = Processor {
    id: "m4f",
    name: "Cortex-M4F",
    package: PACKAGE,
    emulator: Emulator::Arm,
    machine: &["-machine", "mps2-an386"],
    frames: 0x2100_0000,
    model: "m4",
    class: Class::Dsp,
};
const M33: Processor = Processor {
    id: "m33",
    name: "Cortex-M33",
    package: Package { target: Target::Armv8M, ..PACKAGE },
    machine: &["-machine", "mps2-an505"],
    frames: 0x8000_0000,
    class: Class::Plain,
    ..M4F
};

/// All of them.
pub const ALL: [Processor; 6] = [
    Processor {
        id: "m0plus",
        name: "Cortex-M0+",
        package: Package { target: Target::Armv6M, ..PACKAGE },
        model: "m0plus",
        class: Class::Small,
        ..M4F
    },
    M4F,
    M33,
    Processor {
        id: "m33-dsp",
        name: "Cortex-M33 with DSP",
        package: Package { cpu: Some("cortex-m33"), ..M33.package },
        class: Class::Dsp,
        ..M33
    },
    Processor {
        id: "m7",
        name: "Cortex-M7",
        package: Package { cpu: Some("cortex-m7"), features: &["m7"], ..PACKAGE },
        machine: &["-machine", "mps2-an500"],
        frames: 0x6000_0000,
        ..M4F
    },
    Processor {
        id: "rv32imc",
        name: "RV32IMC",
        package: Package { target: Target::Rv32Imc, ..PACKAGE },
        emulator: Emulator::Riscv32,
        machine: &["-machine", "virt", "-bios", "none"],
        frames: 0x8100_0000,
        model: "ibex",
        class: Class::Riscv,
    },
];

/// The processor of this name, or all.
///
/// # Errors
/// No processor has this name; says which there are.
pub fn selected(id: Option<&str>) -> Result<Vec<Processor>> {
    let Some(id) = id else { return Ok(ALL.to_vec()) };
    match ALL.iter().find(|processor| processor.id == id) {
        Some(processor) => Ok(vec![*processor]),
        None => bail!("no processor `{id}`; there are {}", ALL.map(|processor| processor.id).join(", ")),
    }
}
