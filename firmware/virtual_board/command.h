// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// Commands of a person, a test or a script to the board.
#pragma once

#include "board.h"

// Execute one line; return false, with a message on standard error, if it is invalid.
//   hand TARGET STIFFNESS DAMPING MASS [SECONDS [ARRIVES LEADS]]   hold the handle; move the target there in
//       this time, at most at ARRIVES m/s while the hand approaches, then at LEADS; 0: without a speed limit
//   release                                        let the hand release it
//   force NEWTON                                   constant external force
//   position METRE [SECONDS]                       impose the position, until released
//   to | from  drop | flip | insert RATE  probability per byte to, from the board
//   to | from  burst RATE [LENGTH]         probability per byte that random bytes start to replace LENGTH bytes
//   to | from  lose | garble | add COUNT   the next bytes are lost, replaced, preceded by a random one
//   to | from  stall SECONDS               no data pass
//   usb latency SECONDS                    latency timer of the USB chip, 0: none
//   sensor stuck 0|1 | noise COUNTS | jump RATE
//   plug | unplug | reset | freeze | resume | flush | status | quit | go BYTES
bool command_run(struct board *b, const char *line);
