// Properties of the terminal.
#pragma once

namespace sheaf {

/// Width of the terminal that a file descriptor refers to, in columns; 0 if it refers to something else or the width is
/// unknown.
int terminal_columns(int descriptor);

/// Width for text on the standard output, from 40 to 120 columns: that of the terminal, otherwise that of the
/// environment variable COLUMNS, otherwise 80.
int text_columns();

}  // namespace sheaf
