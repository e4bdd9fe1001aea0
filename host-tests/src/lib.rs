//! Desktop side of `concentric`: the simulator and the commands of the program `concentric`.

pub mod accuracy;
pub mod calibrate;
pub mod cli;
pub mod demo;
pub mod detect;
pub mod layout;
pub mod link;
pub mod matching;
pub mod measure;
pub mod monitor;
pub mod overlay;
pub mod paper;
pub mod picture;
pub mod render;
pub mod risk;
pub mod sheet;
pub mod table;
pub mod workload;
