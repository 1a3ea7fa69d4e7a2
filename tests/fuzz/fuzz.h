// Shared code of the fuzz targets. A target is a libFuzzer program that writes each input to a file and reads it.
#pragma once

#include "core/io/error.h"

#include <filesystem>
#include <string_view>

namespace sheaf::fuzz {

/// Defined by each target: reads an input and everything it contains. An Error is an expected result. Other exceptions,
/// hangs and sanitizer reports stop the program.
void try_input(std::string_view input);

/// A folder of this process, removed at exit. It is in memory if the system's folder for temporary files is.
const std::filesystem::path& folder();

/// Writes a file into folder(). The extension of the name selects the format.
std::filesystem::path make_file(std::string_view name, std::string_view bytes);

/// Copies the files of a folder of the repository into folder(), except for those with one extension.
void copy_files(std::string_view repository_folder, std::string_view but_for = "");

/// Removes and returns the first byte, which selects a way of reading; 0 if the input is empty.
unsigned take_choice(std::string_view& input);

/// Whether a text may refer to a file outside of folder(). Such inputs are skipped.
bool leads_out(std::string_view text);

/// Stops the program if a message is empty or too long.
void check_message(std::string_view message);

/// Reads something and returns whether that succeeded. The message of an Error is checked.
template <class Read> bool reads(Read&& read) {
  try {
    read();
    return true;
  } catch (const Error& error) {
    check_message(error.what());
    return false;
  }
}

}  // namespace sheaf::fuzz
