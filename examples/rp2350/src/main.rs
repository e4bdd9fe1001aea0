//! Camera head on an RP2350 with a parallel sensor. See `README.md` beside this package.

#![no_std]
#![no_main]

mod above;
mod sensor;

use concentric::head::{Exposure, Head, Results, buffer_len};
use concentric::report::{Detail, Version};
use concentric::{Detector, Settings, Storage, TargetSpec};
use concentric_embassy_line::{PipeLine, Pipes};
use embassy_executor::Spawner;
use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_rp::i2c::{self, I2c};
use embassy_rp::peripherals::{DMA_CH0, PIO0, UART0};
use embassy_rp::pio::{self, Pio, StateMachine};
use embassy_rp::uart::{self, BufferedUart, BufferedUartRx, BufferedUartTx};
use embassy_rp::{bind_interrupts, dma};
use embassy_sync::zerocopy_channel::Channel;
use embassy_time::Delay;
use panic_halt as _;
use static_cell::{ConstStaticCell, StaticCell};

use sensor::{Row, RowSender, Sensor};

/// Size of a frame, px.
const WIDTH: usize = 324;
const HEIGHT: usize = 324;
/// Most targets in a report.
const TARGETS: usize = 60;
/// Reports that can wait for the line.
const BUFFER: usize = 2 * buffer_len(TARGETS, Detail::Normal);
/// Rows that the sensor can be ahead of the head: a frame, so that a slow head never tears one.
const RING: usize = HEIGHT;
/// Time that the light needs to come up, us.
const LIGHT_LEAD_US: u32 = 20;
const BAUD: u32 = 921_600;
const VERSION: Version = Version { major: 0, minor: 1, patch: 0 };

bind_interrupts!(struct Irqs {
    PIO0_IRQ_0 => pio::InterruptHandler<PIO0>;
    DMA_IRQ_0 => dma::InterruptHandler<DMA_CH0>;
    UART0_IRQ => uart::BufferedInterruptHandler<UART0>;
});

/// A multiple of 32 wide.
static STORAGE: ConstStaticCell<Storage<352, 256, 8000>> = ConstStaticCell::new(Storage::new());
static BYTES: ConstStaticCell<[u8; BUFFER]> = ConstStaticCell::new([0; BUFFER]);
static ROW: ConstStaticCell<[u8; WIDTH]> = ConstStaticCell::new([0; WIDTH]);
/// All zero at level terse, so that it costs neither flash nor stack.
static RESULTS: ConstStaticCell<Results<TARGETS>> = ConstStaticCell::new(Results::new(Detail::Terse));
static ROWS: ConstStaticCell<[Row; RING]> = ConstStaticCell::new([Row::EMPTY; RING]);
static RING_OF_ROWS: StaticCell<
    Channel<'static, embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex, Row>,
> = StaticCell::new();
static TRANSMIT: ConstStaticCell<[u8; 512]> = ConstStaticCell::new([0; 512]);
static RECEIVE: ConstStaticCell<[u8; 64]> = ConstStaticCell::new([0; 64]);
static PIPES: Pipes<512> = Pipes::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = embassy_rp::init(embassy_rp::config::Config::default());

    let mut config = uart::Config::default();
    config.baudrate = BAUD;
    let port = BufferedUart::new(p.UART0, p.PIN_16, p.PIN_17, Irqs, TRANSMIT.take(), RECEIVE.take(), config);
    let (transmitter, receiver) = port.split();
    let (Ok(send), Ok(receive)) = (send(transmitter), receive(receiver)) else { return };
    spawner.spawn(send);
    spawner.spawn(receive);

    let Pio { mut common, sm0: mut machine, .. } = Pio::new(p.PIO0, Irqs);
    let pins = [
        common.make_pio_pin(p.PIN_2),
        common.make_pio_pin(p.PIN_3),
        common.make_pio_pin(p.PIN_4),
        common.make_pio_pin(p.PIN_5),
        common.make_pio_pin(p.PIN_6),
        common.make_pio_pin(p.PIN_7),
        common.make_pio_pin(p.PIN_8),
        common.make_pio_pin(p.PIN_9),
        common.make_pio_pin(p.PIN_10),
        common.make_pio_pin(p.PIN_11),
    ];
    sensor::prepare(&mut common, &mut machine, &pins.each_ref());
    let channel = dma::Channel::new(p.DMA_CH0, Irqs);
    let frame_valid = Input::new(p.PIN_12, Pull::Down);
    let ring = RING_OF_ROWS.init(Channel::new(ROWS.take()));
    let (sender, receiver) = ring.split();
    let Ok(capture) = capture(machine, channel, frame_valid, sender) else { return };
    above::spawner().spawn(capture);

    // A sensor that does not answer sends no frames either.
    let mut bus = I2c::new_blocking(p.I2C1, p.PIN_19, p.PIN_18, i2c::Config::default());
    let _ = sensor::set_up(&mut bus);

    let mut sensor = Sensor::new(receiver);
    let light = Output::new(p.PIN_13, Level::Low);
    let exposure = Exposure::with_light(light, Delay, LIGHT_LEAD_US);
    let mut head = Head::new(PipeLine(&PIPES), exposure, VERSION, BYTES.take());
    let mut detector = Detector::new(Settings::new(TargetSpec::any()), STORAGE.take());
    let results = RESULTS.take();
    results.report.set_detail(Detail::Normal);
    let row = ROW.take();
    loop {
        // What went wrong with a frame shows as the gap in the numbers of the reports.
        let _ = head.frame_async(&mut detector, &mut sensor, row, results).await;
    }
}

#[embassy_executor::task]
async fn capture(
    machine: StateMachine<'static, PIO0, 0>,
    channel: dma::Channel<'static>,
    frame_valid: Input<'static>,
    ring: RowSender,
) {
    sensor::capture(machine, channel, frame_valid, ring).await;
}

#[embassy_executor::task]
async fn send(port: BufferedUartTx) {
    PIPES.send(port).await;
}

#[embassy_executor::task]
async fn receive(port: BufferedUartRx) {
    PIPES.receive(port).await;
}
