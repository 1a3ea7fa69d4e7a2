// What fuzz targets share. A target is a program of libFuzzer that makes a file of each input and reads it.
#pragma once

#include "core/error.h"

#include <filesystem>
#include <string_view>

namespace sheaf::fuzz {

/// What a target does with an input, each its own: reads it, and what it holds. An Error is a good answer; other
/// exceptions end the program, as do hangs and what sanitizers find.
void try_input(std::string_view input);

/// A folder of this process alone, in memory where the system's folder for temporary files is; removed at exit.
const std::filesystem::path& folder();

/// Writes a file into folder(). The name's extension is what chooses among formats.
std::filesystem::path make_file(std::string_view name, std::string_view bytes);

/// Copies what lies in a folder of the repository into folder(), but for files of an extension.
void copy_files(std::string_view repository_folder, std::string_view but_for = "");

/// Takes the first byte off, by which targets choose among ways of reading; 0 if there is none.
unsigned take_choice(std::string_view& input);

/// Whether a text that names files may name one outside of folder(). Such inputs are left alone.
bool leads_out(std::string_view text);

/// Stops the program for a message that is empty or endless.
void check_message(std::string_view message);

/// Reads something; whether that went without an Error, whose message is checked.
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
