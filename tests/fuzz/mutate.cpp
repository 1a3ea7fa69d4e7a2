// main() of the fuzz targets without libFuzzer: runs every seed, then random mutations of the seeds, without feedback
// from coverage. It accepts libFuzzer's options and uses those in kUsage.
#include "tests/support/temporary_folder.h"

#include <sanitizer/asan_interface.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <unistd.h>

extern "C" {
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
/// Targets may define this function. It changes an input in place and returns its new size.
[[gnu::weak]] std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                                  unsigned seed);
}

namespace sheaf::fuzz {

namespace {

namespace fs = std::filesystem;

constexpr const char* kUsage =
    "usage: fuzz_TARGET [OPTION...] FILE|FOLDER...\n"
    "  FILE, FOLDER           inputs to run, and to mutate if there is a folder\n"
    "  -seed=N                seed of the random numbers (default 1)\n"
    "  -max_total_time=S      seconds of mutations (default 10)\n"
    "  -timeout=S             longest time of one input in seconds (default 30)\n"
    "  -dict=FILE             words to insert, one in double quotes per line\n"
    "  -artifact_prefix=PATH  start of the name of the file that keeps a failing input\n"
    "Other options of libFuzzer have no effect.\n";

struct Options {
  std::uint32_t seed = 1;
  double seconds = 10;
  unsigned timeout = 30;
  std::string artifact_prefix;
  std::vector<std::string> words;
  std::vector<std::string> inputs;
  bool mutates = false;
};

/// The input that runs now and where to keep it if it fails. Functions that the sanitizers call on failure read it.
std::string current_input;
std::string artifact;

/// Keeps the current input in a file. Sanitizers call it before they stop the program.
void keep_input() {
  std::fprintf(stderr, "mutate: the failing input is %s\n", artifact.c_str());
  std::ofstream(artifact, std::ios::binary).write(current_input.data(), std::streamsize(current_input.size()));
}

/// Handles abort() and the end of an input's time.
void stop(int signal) {
  if (signal == SIGALRM) std::fputs("mutate: the input takes too long\n", stderr);
  keep_input();
  std::_Exit(1);
}

std::vector<std::string> read_dictionary(const fs::path& path) {
  std::vector<std::string> words;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);)
    if (line.size() > 2 && line.front() == '"' && line.back() == '"') words.push_back(line.substr(1, line.size() - 2));
  return words;
}

/// Adds a file, or all files of a folder in the order of their names.
void add_inputs(Options& options, const fs::path& path) {
  if (!fs::is_directory(path)) {
    options.inputs.push_back(read_bytes(path));
    return;
  }
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(path)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) options.inputs.push_back(read_bytes(file));
  options.mutates = true;
}

Options parse_options(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const std::size_t equals = argument.find('=');
    const std::string name = argument.substr(0, equals);
    const std::string value = equals == std::string::npos ? "" : argument.substr(equals + 1);
    if (argument.front() != '-') {
      add_inputs(options, argument);
    } else if (name == "-seed") {
      options.seed = static_cast<std::uint32_t>(std::stoul(value));
    } else if (name == "-max_total_time") {
      options.seconds = std::stod(value);
    } else if (name == "-timeout") {
      options.timeout = static_cast<unsigned>(std::stoul(value));
    } else if (name == "-dict") {
      options.words = read_dictionary(value);
    } else if (name == "-artifact_prefix") {
      options.artifact_prefix = value;
    }
  }
  return options;
}

/// Random changes of an input, in the manner of libFuzzer's mutations.
class Mutator {
 public:
  explicit Mutator(const Options& options) : options_(options), random_(options.seed) {}

  /// A seed with one to four changes, or changed by the target's own function.
  std::string operator()() {
    std::string input = options_.inputs[below(options_.inputs.size())];
    if (LLVMFuzzerCustomMutator == nullptr) {
      for (std::size_t changes = 1 + below(4); changes > 0; --changes) change(input);
      return input;
    }
    constexpr std::size_t kRoom = 4096;
    const std::size_t size = input.size();
    input.resize(size + kRoom);
    input.resize(LLVMFuzzerCustomMutator(reinterpret_cast<std::uint8_t*>(input.data()), size, input.size(),
                                         static_cast<unsigned>(random_())));
    return input;
  }

  /// One change.
  void change(std::string& input) {
    switch (below(8)) {
      case 0:  // Flip a bit.
        if (!input.empty()) input[below(input.size())] ^= static_cast<char>(1u << below(8));
        break;
      case 1:  // Replace a byte.
        if (!input.empty()) input[below(input.size())] = static_cast<char>(below(256));
        break;
      case 2:  // Remove a range.
        input.erase(below(input.size() + 1), 1 + below(32));
        break;
      case 3:  // Truncate.
        input.resize(below(input.size() + 1));
        break;
      case 4:  // Repeat a range at another place.
        input.insert(below(input.size() + 1), input.substr(below(input.size() + 1), 1 + below(64)));
        break;
      case 5:  // Insert a word of the dictionary.
        if (!options_.words.empty())
          input.insert(below(input.size() + 1), options_.words[below(options_.words.size())]);
        break;
      case 6:
        replace_number(input);
        break;
      default:
        splice(input);
    }
  }

 private:
  std::size_t below(std::size_t count) { return count == 0 ? 0 : random_() % count; }

  /// Replaces a decimal number of a text, or four bytes of a binary file, by an extreme value.
  void replace_number(std::string& input) {
    static constexpr std::array kTexts = {"-1",         "0",          "1e38", "1e-40", "nan",
                                          "2147483648", "4294967295", "-0.5", "1e999"};
    static constexpr std::array<std::uint32_t, 8> kValues = {0,          1,          0x7fffffff, 0x80000000,
                                                             0xffffffff, 0x7f800000, 0x7fc00000, 0x10000};
    constexpr const char* kDigits = "0123456789";
    const std::size_t first = input.find_first_of(kDigits, below(input.size() + 1));
    if (first != std::string::npos && below(2) == 0) {
      const std::size_t last = input.find_first_not_of("0123456789.eE", first);
      input.replace(first, std::min(last, input.size()) - first, kTexts[below(kTexts.size())]);
    } else if (input.size() >= 4) {
      const std::uint32_t value = kValues[below(kValues.size())];
      input.replace(below(input.size() - 3), 4, reinterpret_cast<const char*>(&value), 4);
    }
  }

  /// Continues with the end of another seed.
  void splice(std::string& input) {
    const std::string& other = options_.inputs[below(options_.inputs.size())];
    input.resize(below(input.size() + 1));
    input += other.substr(below(other.size() + 1));
  }

  const Options& options_;
  std::mt19937 random_;
};

/// The mutator of this program, for LLVMFuzzerMutate().
Mutator* current_mutator = nullptr;

/// Runs one input, at most for the time limit of the options.
void run(const Options& options, std::string input) {
  current_input = std::move(input);
  alarm(options.timeout);
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(current_input.data()), current_input.size());
  alarm(0);
}

}  // namespace

}  // namespace sheaf::fuzz

/// libFuzzer's function for custom mutators: changes an input in place and returns its new size.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size) {
  std::string input(reinterpret_cast<const char*>(data), size);
  sheaf::fuzz::current_mutator->change(input);
  const std::size_t changed = std::min(input.size(), max_size);
  std::memcpy(data, input.data(), changed);
  return changed;
}

int main(int argc, char** argv) {
  using namespace sheaf::fuzz;
  const Options options = parse_options(argc, argv);
  if (options.inputs.empty()) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  artifact = options.artifact_prefix + "crash-" + std::to_string(getpid());
  __sanitizer_set_death_callback(keep_input);
  std::signal(SIGABRT, stop);
  std::signal(SIGALRM, stop);

  for (const std::string& input : options.inputs) run(options, input);
  if (!options.mutates) return 0;
  Mutator mutate(options);
  current_mutator = &mutate;
  std::size_t count = 0;
  const auto start = std::chrono::steady_clock::now();
  while (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() < options.seconds) {
    run(options, mutate());
    ++count;
  }
  std::printf("mutate: %zu seeds, %zu mutations\n", options.inputs.size(), count);
  return 0;
}
