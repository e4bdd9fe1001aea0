//! What an instruction does to memory, and a model of its cycles.
//!
//! Cycles are those of the makers' tables with memory that never makes the processor wait:
//!
//! * `m0plus`: Arm, "Cortex-M0+ Technical Reference Manual", table of instructions; multiplier of one cycle.
//! * `m4`: Arm, "Cortex-M4 Technical Reference Manual" (100166), table 3-1; 2 cycles to refill the pipeline after a
//!   branch (the manual says 1 to 3), and loads and stores in a row overlap.
//! * `ibex`: lowRISC, "Ibex Reference Manual", pipeline details; multiplier of 3 cycles.

/// Cycles that a Cortex-M4 takes to refill its pipeline.
const REFILL: u64 = 2;

/// A processor whose cycles are modelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// Cortex-M0+.
    M0Plus,
    /// Cortex-M4, and M33 for want of a table.
    M4,
    /// Ibex: RV32IMC with two stages.
    Ibex,
}

impl Model {
    /// The model of this name.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "m0plus" => Some(Self::M0Plus),
            "m4" => Some(Self::M4),
            "ibex" => Some(Self::Ibex),
            _ => None,
        }
    }

    /// What an instruction costs after another.
    pub fn cost(self, code: &[u8], before: &Cost) -> Cost {
        let half = |i: usize| match code.get(2 * i..2 * i + 2) {
            Some(&[low, high]) => u16::from_le_bytes([low, high]),
            _ => 0,
        };
        match (self, code.len()) {
            (Self::Ibex, 2) => riscv_short(half(0)),
            (Self::Ibex, _) => riscv(u32::from(half(0)) | u32::from(half(1)) << 16),
            (_, 2) => Thumb { model: self, after_access: before.is_access }.short(half(0)),
            _ => Thumb { model: self, after_access: before.is_access }.long(half(0), half(1)),
        }
    }
}

/// What an instruction does and costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Words, or less, that it loads.
    pub loads: u64,
    /// Words, or less, that it stores.
    pub stores: u64,
    /// Cycles, if it does not branch.
    pub cycles: u64,
    /// What a taken branch adds.
    pub branch: u64,
    /// One load or store, whose wait the next one hides.
    is_access: bool,
    /// It stores relative to the stack pointer.
    pub is_on_stack: bool,
}

impl Cost {
    fn of(cycles: u64) -> Self {
        Self { cycles, ..Self::default() }
    }

    fn branch(cycles: u64, branch: u64) -> Self {
        Self { branch, ..Self::of(cycles) }
    }
}

struct Thumb {
    model: Model,
    after_access: bool,
}

impl Thumb {
    fn refill(&self) -> u64 {
        if self.model == Model::M0Plus { 1 } else { REFILL }
    }

    fn load(&self) -> Cost {
        let hidden = self.model == Model::M4 && self.after_access;
        Cost { loads: 1, is_access: true, ..Cost::of(if hidden { 1 } else { 2 }) }
    }

    fn store(&self) -> Cost {
        Cost { stores: 1, is_access: true, ..Cost::of(if self.model == Model::M0Plus { 2 } else { 1 }) }
    }

    fn access(&self, is_load: bool) -> Cost {
        if is_load { self.load() } else { self.store() }
    }

    fn several(&self, registers: u16, is_load: bool) -> Cost {
        let count = u64::from(registers.count_ones());
        let (loads, stores) = if is_load { (count, 0) } else { (0, count) };
        Cost { loads, stores, ..Cost::of(1 + count) }
    }

    /// An instruction of 16 bits.
    fn short(&self, code: u16) -> Cost {
        let is_load = code & 0x0800 != 0;
        match code >> 12 {
            // BX, BLX; LDR of a literal; arithmetic into the program counter.
            0x4 if code & 0xff00 == 0x4700 => Cost::branch(1, self.refill()),
            0x4 if is_load => self.load(),
            0x4 if code & 0xfc87 == 0x4487 => Cost::branch(1, self.refill()),
            // Loads and stores with a register, a constant, the stack pointer.
            0x5 => self.access(code >> 9 & 7 >= 3),
            0x6..=0x8 => self.access(is_load),
            0x9 => Cost { is_on_stack: true, ..self.access(is_load) },
            0xb => self.other_short(code),
            0xc => self.several(code & 0xff, is_load),
            // Conditional branches, branches.
            0xd if code & 0x0f00 < 0x0e00 => Cost::branch(1, self.refill()),
            0xe => Cost::branch(1, self.refill()),
            _ => Cost::of(1),
        }
    }

    fn other_short(&self, code: u16) -> Cost {
        match code {
            // PUSH, POP.
            _ if code & 0xfe00 == 0xb400 => Cost { is_on_stack: true, ..self.several(code & 0x1ff, false) },
            _ if code & 0xfe00 == 0xbc00 => {
                let returns = code & 0x100 != 0;
                Cost { branch: if returns { 2 } else { 0 }, ..self.several(code & 0x1ff, true) }
            }
            // CBZ, CBNZ.
            _ if code & 0xf500 == 0xb100 => Cost::branch(1, self.refill()),
            // IT is folded into the instruction before it.
            _ if code & 0xff00 == 0xbf00 && code & 0xf != 0 => Cost::of(0),
            _ => Cost::of(1),
        }
    }

    /// An instruction of 32 bits.
    fn long(&self, first: u16, second: u16) -> Cost {
        match first >> 11 & 3 {
            2 if second & 0x8000 != 0 => self.control(first, second),
            1 if first & 0x0600 == 0 => self.double_or_several(first, second),
            1 | 3 if first & 0x0400 != 0 => float(first, second),
            // Single loads and stores; a load of the program counter branches.
            3 if first & 0x0600 == 0 => {
                let is_load = first & 0x10 != 0;
                let jumps = is_load && second >> 12 == 15 && first & 0x60 == 0x40;
                Cost { branch: if jumps { REFILL } else { 0 }, ..self.access(is_load) }
            }
            // SDIV and UDIV take 2 to 12.
            3 if first & 0xffd0 == 0xfb90 => Cost::of(6),
            _ => Cost::of(1),
        }
    }

    /// Branches and access to special registers.
    fn control(&self, first: u16, second: u16) -> Cost {
        let m0 = self.model == Model::M0Plus;
        match second >> 12 & 5 {
            0 if first & 0x0380 != 0x0380 => Cost::branch(1, self.refill()),
            1 => Cost::branch(1, self.refill()),
            // BL: 3 on the M0+.
            5 => Cost::branch(if m0 { 2 } else { 1 }, self.refill()),
            _ => Cost::of(if m0 { 3 } else { 1 }),
        }
    }

    /// LDM and STM, table branches, LDRD and STRD, exclusive access.
    fn double_or_several(&self, first: u16, second: u16) -> Cost {
        let is_load = first & 0x10 != 0;
        if first & 0x0040 == 0 {
            let jumps = is_load && second & 0x8000 != 0;
            Cost { branch: if jumps { REFILL } else { 0 }, ..self.several(second, is_load) }
        } else if first & 0xfff0 == 0xe8d0 && second & 0xffe0 == 0xf000 {
            Cost { loads: 1, branch: REFILL, ..Cost::of(2) }
        } else {
            let (loads, stores) = if is_load { (2, 0) } else { (0, 2) };
            Cost { loads, stores, ..Cost::of(3) }
        }
    }
}

/// The floating-point unit.
fn float(first: u16, second: u16) -> Cost {
    if first & 0x0200 == 0 {
        // Two registers of the core at once; one register, or several, of memory.
        if first & 0x0fe0 == 0x0c40 {
            return Cost::of(2);
        }
        let is_single = first & 0x0120 == 0x0100;
        let is_double = second & 0x100 != 0;
        let words = if is_single { 1 + u64::from(is_double) } else { u64::from(second & 0xff) };
        let (loads, stores) = if first & 0x10 != 0 { (words, 0) } else { (0, words) };
        return Cost { loads, stores, ..Cost::of(1 + words) };
    }
    if second & 0x10 != 0 {
        return Cost::of(1);
    }
    // VDIV and VSQRT; multiplication with addition; the rest.
    let is_root = first & 0xf == 1 && second & 0x80 != 0 && second & 0x40 != 0;
    Cost::of(match first >> 4 & 0xb {
        0x8 => 14,
        0xb if is_root => 14,
        0x0 | 0x1 | 0x9 | 0xa => 3,
        _ => 1,
    })
}

const RISCV_LOAD: Cost =
    Cost { loads: 1, stores: 0, cycles: 2, branch: 0, is_access: true, is_on_stack: false };
const RISCV_STORE: Cost =
    Cost { loads: 0, stores: 1, cycles: 2, branch: 0, is_access: true, is_on_stack: false };
const RISCV_BRANCH: u64 = 2;
const RISCV_JUMP: u64 = 1;

/// A compressed instruction.
fn riscv_short(code: u16) -> Cost {
    match (code & 3, code >> 13) {
        (0, 4..) => RISCV_STORE,
        (0, 1..) | (2, 2) => RISCV_LOAD,
        (1, 1 | 5) => Cost::branch(1, RISCV_JUMP),
        (1, 6 | 7) => Cost::branch(1, RISCV_BRANCH),
        (2, 6) => Cost { is_on_stack: true, ..RISCV_STORE },
        // C.JR, C.JALR.
        (2, 4) if code & 0x7c == 0 && code & 0xf80 != 0 => Cost::branch(1, RISCV_JUMP),
        _ => Cost::of(1),
    }
}

fn riscv(code: u32) -> Cost {
    const STACK_POINTER: u32 = 2;
    match code & 0x7f {
        0x03 => RISCV_LOAD,
        0x23 => Cost { is_on_stack: code >> 15 & 31 == STACK_POINTER, ..RISCV_STORE },
        0x63 => Cost::branch(1, RISCV_BRANCH),
        0x67 | 0x6f => Cost::branch(1, RISCV_JUMP),
        // MUL and its kin, DIV and its kin.
        0x33 if code >> 25 == 1 => Cost::of(if code >> 12 & 7 < 4 { 3 } else { 37 }),
        _ => Cost::of(1),
    }
}
