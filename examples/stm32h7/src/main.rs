//! Camera head on an STM32H743 with a parallel sensor. See `README.md` beside this package.

#![no_std]
#![no_main]

mod camera;
mod placement;

use concentric::head::{Exposure, Head, Results, buffer_len};
use concentric::report::{Detail, Version};
use concentric::{Detector, Settings, Storage, TargetSpec};
use concentric_embassy_line::{PipeLine, Pipes};
use embassy_executor::Spawner;
use embassy_stm32::dcmi::{self, Dcmi};
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::i2c::{self, I2c};
use embassy_stm32::time::Hertz;
use embassy_stm32::usart::{self, BufferedUart, BufferedUartRx, BufferedUartTx};
use embassy_stm32::{bind_interrupts, dma, peripherals};
use embassy_time::Delay;
use panic_halt as _;
use static_cell::ConstStaticCell;

use camera::Camera;

/// Size of a frame, px.
const WIDTH: usize = 640;
const HEIGHT: usize = 480;
/// The same in words of memory.
const FRAME_WORDS: usize = WIDTH * HEIGHT / 4;
/// Most targets in a report.
const TARGETS: usize = 48;
/// Reports that can wait for the line.
const BUFFER: usize = 2 * buffer_len(TARGETS, Detail::Normal);
/// Time that the light needs to come up, us.
const LIGHT_LEAD_US: u32 = 20;
const BAUD: u32 = 921_600;
const VERSION: Version = Version { major: 0, minor: 1, patch: 0 };

bind_interrupts!(struct Irqs {
    DCMI => dcmi::InterruptHandler<peripherals::DCMI>;
    DMA1_STREAM0 => dma::InterruptHandler<peripherals::DMA1_CH0>;
    USART3 => usart::BufferedInterruptHandler<peripherals::USART3>;
});

static STORAGE: ConstStaticCell<Storage<WIDTH, 128, 2600>> = ConstStaticCell::new(Storage::new());
static BYTES: ConstStaticCell<[u8; BUFFER]> = ConstStaticCell::new([0; BUFFER]);
static ROW: ConstStaticCell<[u8; WIDTH]> = ConstStaticCell::new([0; WIDTH]);
/// All zero at level terse, so that it costs neither flash nor stack.
static RESULTS: ConstStaticCell<Results<TARGETS>> = ConstStaticCell::new(Results::new(Detail::Terse));
static TRANSMIT: ConstStaticCell<[u8; 512]> = ConstStaticCell::new([0; 512]);
static RECEIVE: ConstStaticCell<[u8; 64]> = ConstStaticCell::new([0; 64]);
static PIPES: Pipes<512> = Pipes::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = embassy_stm32::init(clocks());
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.SCB.enable_icache();
    }

    let mut config = usart::Config::default();
    config.baudrate = BAUD;
    let port = BufferedUart::new(p.USART3, p.PD9, p.PD8, TRANSMIT.take(), RECEIVE.take(), Irqs, config);
    let Ok(port) = port else { return };
    let (transmitter, receiver) = port.split();
    let (Ok(send), Ok(receive)) = (send(transmitter), receive(receiver)) else { return };
    spawner.spawn(send);
    spawner.spawn(receive);

    let mut config = i2c::Config::default();
    config.frequency = Hertz::khz(100);
    // A sensor that does not answer sends no frames either, which the loop below meets.
    let _ = camera::set_up(&mut I2c::new_blocking(p.I2C1, p.PB8, p.PB9, config));

    let mut config = dcmi::Config::default();
    config.vsync_level = dcmi::VSyncDataInvalidLevel::Low;
    config.hsync_level = dcmi::HSyncDataInvalidLevel::Low;
    let dcmi = Dcmi::new_8bit(
        p.DCMI, p.DMA1_CH0, Irqs, p.PC6, p.PC7, p.PE0, p.PE1, p.PE4, p.PD3, p.PE5, p.PE6, p.PB7, p.PA4,
        p.PA6, config,
    );
    let Some(frame) = placement::frame() else { return };
    let mut camera = Camera::new(dcmi, frame);

    let light = Output::new(p.PB0, Level::Low, Speed::Low);
    let exposure = Exposure::with_light(light, Delay, LIGHT_LEAD_US);
    let mut head = Head::new(PipeLine(&PIPES), exposure, VERSION, BYTES.take());
    let mut detector = Detector::new(Settings::new(TargetSpec::any()), STORAGE.take());
    let results = RESULTS.take();
    results.report.set_detail(Detail::Normal);
    let row = ROW.take();
    loop {
        // What went wrong with a frame shows as the gap in the numbers of the reports.
        let _ = head.frame_async(&mut detector, &mut camera, row, results).await;
    }
}

/// 400 MHz from the internal oscillator, 200 MHz for the memories, 100 MHz for the peripherals.
fn clocks() -> embassy_stm32::Config {
    use embassy_stm32::rcc::*;

    let mut config = embassy_stm32::Config::default();
    config.rcc.hsi = Some(HSIPrescaler::DIV1);
    config.rcc.pll1 = Some(Pll {
        source: PllSource::HSI,
        prediv: PllPreDiv::DIV4,
        mul: PllMul::MUL50,
        fracn: None,
        divp: Some(PllDiv::DIV2),
        divq: None,
        divr: None,
    });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV2;
    config.rcc.apb1_pre = APBPrescaler::DIV2;
    config.rcc.apb2_pre = APBPrescaler::DIV2;
    config.rcc.apb3_pre = APBPrescaler::DIV2;
    config.rcc.apb4_pre = APBPrescaler::DIV2;
    config.rcc.voltage_scale = VoltageScale::Scale1;
    config
}

#[embassy_executor::task]
async fn send(port: BufferedUartTx<'static>) {
    PIPES.send(port).await;
}

#[embassy_executor::task]
async fn receive(port: BufferedUartRx<'static>) {
    PIPES.receive(port).await;
}
