// What signals ask of a verb. A handler only notes it; whoever runs the verb looks between two cycles.
//   catch_signals();                            // main
//   hold_machine(Terminal::Matters);            // a verb, before it brings a machine up
//   if (interrupted()) ...   if (take_hold_wish()) ...
// SIGINT, SIGTERM, SIGQUIT, SIGHUP and, for a verb that holds a machine, SIGPIPE ask it to end in order. A second
// SIGINT, SIGTERM or SIGQUIT ends the program at once, with the stop frame as the last word on the bus. Two that come
// within 0.2 s are one: `timeout` and a terminal's group send the same wish twice. SIGHUP and SIGPIPE never insist:
// they come in company when a terminal goes.
#pragma once

namespace gantry::cli {

/// Once, in main.
void catch_signals();

/// Whether a verb ends with the terminal that it was started on.
enum class Terminal {
  Matters,
  MattersIfThereIsOne  ///< a service without a controlling terminal ignores SIGHUP, and that nobody reads its log
};

/// For a verb that holds the machine: a lost terminal and a log that nobody reads any more end it in order, terminal
/// access from the background does not stop the process, and a write to stderr never waits (what nobody takes is
/// dropped). A SIGHUP that was ignored at the start (nohup) stays ignored.
void hold_machine(Terminal terminal);
/// Ctrl-Z is a wish that take_hold_wish() tells; it does not stop the process and its loop.
void hold_on_stop_key();

/// As a program without hold_on_stop_key() does on Ctrl-Z: the shell gets its terminal, and this returns after `fg`. It
/// returns at once where no shell could ever say that.
void stop_for_shell();

/// The verb was asked to end, or nobody reads its log any more.
bool interrupted();
/// It was asked by the loss of its terminal alone, and by nobody.
bool terminal_lost();
/// Found by whoever reads the terminal.
void lose_terminal();

/// Ctrl-Z since the last call.
bool take_hold_wish();
/// SIGCONT (`fg`, `bg`) since the last call.
bool take_continued();

}  // namespace gantry::cli
