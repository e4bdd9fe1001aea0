//! Desktop side of `concentric`: the simulator and the commands of the program `concentric`.
