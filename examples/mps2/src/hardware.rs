//! Everything that needs `unsafe`: where the registers are, and the end of the program.

#![allow(unsafe_code)]

use concentric_mailbox_head::Words;

/// UART0 of the boards (CMSDK APB UART).
pub fn uart0() -> Words {
    // SAFETY: the registers of a device that only this program uses, and only once.
    unsafe { Words::new(0x4000_4000, 5) }
}

/// Ends the program: QEMU exits with `status`.
pub fn exit(status: u32) -> ! {
    const EXIT_EXTENDED: usize = 0x20;
    const APPLICATION_EXIT: usize = 0x2_0026;
    loop {
        // SAFETY: the call reads the two words of the block and nothing else.
        unsafe {
            cortex_m_semihosting::syscall(EXIT_EXTENDED, &[APPLICATION_EXIT, status as usize]);
        }
    }
}
