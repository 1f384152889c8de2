// Ctrl-Z and a machine: a shell takes its terminal back only from a process that stops, and a process that stops takes
// the 1 ms loop with it (docs/decisions/012). So a verb that holds the machine and has keys is two processes: the one
// that the shell started waits in front, and its child holds the machine. The front stops alone.
//   stand_behind_a_front();      // returns in the child; the front ends with the child's exit status
//   stop_front();                // the machine is held: the shell may have its terminal
// Signals that the front gets are passed on. A front that is killed counts as a lost terminal.
#pragma once

namespace gantry::cli {

/// Before the first thread. Does nothing when stdin is no terminal.
void stand_behind_a_front();
bool has_front();
/// SIGCONT (`fg`) lets it go on, and is passed on.
void stop_front();

}  // namespace gantry::cli
