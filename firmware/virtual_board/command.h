// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// What a person, a test or a script can do to the board.
#pragma once

#include "board.h"

// Carry out one line; false with a message on standard error if it is not understood.
//   hand TARGET STIFFNESS DAMPING MASS [SECONDS [ARRIVES LEADS]]   hold the handle; move the target there in
//       that time, but no faster than ARRIVES m/s where the hand takes it, then LEADS; 0: as fast as it takes
//   release                                        let go of it
//   force NEWTON                                   constant external force
//   position METRE [SECONDS]                       impose the position, until released
//   to | from  drop | flip | insert RATE  probability per byte to, from the board
//   to | from  burst RATE [LENGTH]         probability per byte that random ones begin to replace so many
//   to | from  lose | garble | add COUNT   the next bytes are lost, replaced, preceded by a random one
//   to | from  stall SECONDS               nothing comes through
//   usb latency SECONDS                    latency timer of the USB chip, 0: none
//   sensor stuck 0|1 | noise COUNTS | jump RATE
//   plug | unplug | reset | freeze | resume | flush | status | quit | go BYTES
bool command_run(struct board *b, const char *line);
