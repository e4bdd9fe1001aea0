//! The part of QEMU's plugin interface, version 1 (QEMU 4.2 to 8.2), that is used.
//!
//! The prototypes are those of QEMU's header `qemu-plugin.h`; QEMU itself has the functions.

#![allow(unsafe_code)]

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::ptr;
use std::slice;

use crate::{Block, ended, marked, set_up, translated};

/// Version of the interface: QEMU refuses a plugin of one that it does not know.
#[unsafe(no_mangle)]
#[allow(non_upper_case_globals, reason = "the name is QEMU's")]
pub static qemu_plugin_version: c_int = 1;

#[repr(C)]
struct RawBlock([u8; 0]);
#[repr(C)]
struct RawInstruction([u8; 0]);

const ADD: c_int = 0;
const NO_REGISTERS: c_int = 0;
const WRITES: c_int = 2;

unsafe extern "C" {
    fn qemu_plugin_register_vcpu_tb_trans_cb(id: u64, call: extern "C" fn(u64, *mut RawBlock));
    fn qemu_plugin_register_vcpu_tb_exec_cb(
        block: *mut RawBlock,
        call: extern "C" fn(c_uint, *mut c_void),
        flags: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_register_vcpu_tb_exec_inline(
        block: *mut RawBlock,
        operation: c_int,
        place: *mut c_void,
        amount: u64,
    );
    fn qemu_plugin_register_vcpu_mem_cb(
        instruction: *mut RawInstruction,
        call: extern "C" fn(c_uint, u32, u64, *mut c_void),
        flags: c_int,
        accesses: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_register_atexit_cb(id: u64, call: extern "C" fn(u64, *mut c_void), data: *mut c_void);
    fn qemu_plugin_tb_n_insns(block: *const RawBlock) -> usize;
    fn qemu_plugin_tb_vaddr(block: *const RawBlock) -> u64;
    fn qemu_plugin_tb_get_insn(block: *const RawBlock, index: usize) -> *mut RawInstruction;
    fn qemu_plugin_insn_data(instruction: *const RawInstruction) -> *const u8;
    fn qemu_plugin_insn_size(instruction: *const RawInstruction) -> usize;
    fn qemu_plugin_insn_vaddr(instruction: *const RawInstruction) -> u64;
    fn qemu_plugin_insn_symbol(instruction: *const RawInstruction) -> *const c_char;
}

/// An instruction of a block that is being translated; lives as long as that call.
pub struct Instruction(*mut RawInstruction);

impl Instruction {
    /// Its code, 2 or 4 bytes.
    pub fn code(&self) -> &[u8] {
        // SAFETY: QEMU keeps the bytes while the block is translated.
        unsafe { slice::from_raw_parts(qemu_plugin_insn_data(self.0), qemu_plugin_insn_size(self.0)) }
    }

    /// Where it is.
    pub fn address(&self) -> u64 {
        // SAFETY: the instruction is one of QEMU's.
        unsafe { qemu_plugin_insn_vaddr(self.0) }
    }

    /// The function that it is in, if the image has its name.
    pub fn function(&self) -> Option<String> {
        // SAFETY: QEMU gives a string that ends, or null.
        unsafe {
            let name = qemu_plugin_insn_symbol(self.0);
            (!name.is_null()).then(|| CStr::from_ptr(name).to_string_lossy().into_owned())
        }
    }

    /// Tells `marked` the address of each of its stores.
    pub fn tell_stores(&self) {
        // SAFETY: the function has the prototype that QEMU asks for.
        unsafe {
            qemu_plugin_register_vcpu_mem_cb(self.0, on_store, NO_REGISTERS, WRITES, ptr::null_mut());
        }
    }
}

extern "C" fn on_store(_processor: c_uint, _info: u32, address: u64, _data: *mut c_void) {
    marked(address);
}

extern "C" fn on_translation(_id: u64, raw: *mut RawBlock) {
    // SAFETY: `raw` is QEMU's block, and the indices are below its number of instructions.
    let (instructions, start) = unsafe {
        let count = qemu_plugin_tb_n_insns(raw);
        let instructions: Vec<_> = (0..count).map(|i| Instruction(qemu_plugin_tb_get_insn(raw, i))).collect();
        (instructions, qemu_plugin_tb_vaddr(raw))
    };
    let Some((block, sums)) = translated(&instructions, start) else { return };
    for (count, amount) in sums {
        // SAFETY: the count is a u64 that lives for ever. The machine has one processor, in one thread.
        unsafe { qemu_plugin_register_vcpu_tb_exec_inline(raw, ADD, count.as_ptr().cast(), amount) }
    }
    let block: &'static Block = Box::leak(Box::new(block));
    // SAFETY: the function has the prototype that QEMU asks for, and its data live for ever.
    unsafe {
        let data = ptr::from_ref(block).cast_mut().cast();
        qemu_plugin_register_vcpu_tb_exec_cb(raw, on_block, NO_REGISTERS, data);
    }
}

extern "C" fn on_block(_processor: c_uint, data: *mut c_void) {
    // SAFETY: `on_translation` gave a block that lives for ever.
    unsafe { &*data.cast::<Block>() }.enter();
}

extern "C" fn on_exit(_id: u64, _data: *mut c_void) {
    ended();
}

/// QEMU calls this first.
///
/// # Safety
/// For QEMU alone: `arguments` must be `count` strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn qemu_plugin_install(
    id: u64,
    _info: *const c_void,
    count: c_int,
    arguments: *const *const c_char,
) -> c_int {
    let texts: Vec<_> = (0..count as usize)
        // SAFETY: as the caller promises.
        .map(|i| unsafe { CStr::from_ptr(*arguments.add(i)) }.to_string_lossy().into_owned())
        .collect();
    if !set_up(&texts) {
        return 1;
    }
    // SAFETY: the functions have the prototypes that QEMU asks for.
    unsafe {
        qemu_plugin_register_vcpu_tb_trans_cb(id, on_translation);
        qemu_plugin_register_atexit_cb(id, on_exit, ptr::null_mut());
    }
    0
}
