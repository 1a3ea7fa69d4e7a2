// NanoVDB files. Mutants of a compressed grid are rarely valid, so the grid is mutated before compression, mostly near
// its beginning, where the headers of grid, tree and nodes are.
#include "core/io/inflate.h"
#include "scene/formats/nanovdb.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/files/deflate.h"

#include <cstring>
#include <random>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace sheaf::fuzz {

namespace {

/// A file with one compressed grid: the bytes before the grid, and the grid as it is in memory.
struct GridFile {
  std::string head, grid;

  /// Throws Error if the bytes are not such a file.
  explicit GridFile(std::string_view bytes) {
    constexpr std::size_t kSegment = 16, kEntry = 176, kNameSize = 136, kMax = std::size_t{1} << 20;
    std::uint32_t name_size = 0;
    std::uint64_t size = 0;
    if (bytes.size() < kSegment + kEntry) throw Error(ExitCode::kRuntime, "too short");
    std::memcpy(&size, bytes.data() + kSegment, sizeof size);
    std::memcpy(&name_size, bytes.data() + kSegment + kNameSize, sizeof name_size);
    const std::size_t begin = kSegment + kEntry + name_size + sizeof size;
    if (bytes.size() < begin || size > kMax) throw Error(ExitCode::kRuntime, "no grid");
    head = bytes.substr(0, begin - sizeof size);
    grid.resize(size);
    grid.resize(Inflater(bytes.substr(begin)).read(grid));
  }

  std::string bytes() const {
    const std::string stream = test::deflated(grid, 1);
    const std::uint64_t stored = stream.size(), all = stored + sizeof stored;
    std::string out = head;
    std::memcpy(out.data() + 16 + 8, &all, sizeof all);  // the entry's size of the grid in the file
    out.append(reinterpret_cast<const char*>(&stored), sizeof stored);
    return out + stream;
  }
};

}  // namespace

void try_input(std::string_view input) {
  const auto file = make_file("grid.nvdb", input);
  reads([&] { (void)read_nanovdb(file, ""); });
  reads([&] {
    if (has_nanovdb_grid(file, "heat")) (void)read_nanovdb(file, "heat");
  });
}

}  // namespace sheaf::fuzz

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  std::mt19937 random(seed);
  if (random() % 4 == 0) return LLVMFuzzerMutate(data, size, max_size);
  try {
    sheaf::fuzz::GridFile file({reinterpret_cast<const char*>(data), size});
    constexpr std::size_t kHeaders = 2048, kWindow = 64;
    if (file.grid.size() < kHeaders) return LLVMFuzzerMutate(data, size, max_size);
    const std::size_t range = random() % 4 != 0 ? kHeaders : file.grid.size();
    auto* const window = reinterpret_cast<std::uint8_t*>(file.grid.data()) + random() % (range - kWindow);
    LLVMFuzzerMutate(window, 1 + random() % kWindow, kWindow);
    const std::string bytes = file.bytes();
    if (bytes.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
    std::memcpy(data, bytes.data(), bytes.size());
    return bytes.size();
  } catch (const sheaf::Error&) { return LLVMFuzzerMutate(data, size, max_size); }
}
