// Launcher `sheaf` of packages and releases: starts the best build for the processor. It is compiled for the baseline
// instruction set, so that it can report missing instructions.
#include <fmt/format.h>

#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

namespace {

/// A build, named after the microarchitecture level that it requires; see the x86-64 psABI.
struct Build {
  const char* level;
  bool runs;  ///< on this processor
};

// Clang before 17 does not know levels by name. These are the instructions of the levels that it can test. Processors
// that have them also have the others (F16C, LZCNT, MOVBE).
bool has_v3() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
         __builtin_cpu_supports("fma");
}
bool has_v4() {
  return has_v3() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
}

int fail(const std::string& message) {
  std::fprintf(stderr, "sheaf: %s\n", message.c_str());
  return 1;
}

}  // namespace

int main(int, char** argv) {
  namespace fs = std::filesystem;
  __builtin_cpu_init();
  // Find the builds that this processor can run.
  const std::array<Build, 2> builds{{{"x86-64-v4", has_v4()}, {"x86-64-v3", has_v3()}}};
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (error) return fail("cannot locate the program: " + error.message());
  const char* const requested = std::getenv("SHEAF_ISA");
  bool known = false;
  // Start the best build, or the one that SHEAF_ISA requests.
  for (const Build& build : builds) {
    if (requested != nullptr && *requested != '\0' && std::strcmp(requested, build.level) != 0) continue;
    known = true;
    if (!build.runs) continue;
    const fs::path program = self.parent_path().parent_path() / "lib" / "sheaf" / build.level / "sheaf";
    execv(program.c_str(), argv);
    return fail(fmt::format("cannot start '{}': {}", program.string(), std::strerror(errno)));
  }
  if (!known) return fail(fmt::format("SHEAF_ISA is '{}': expected x86-64-v4, x86-64-v3 or nothing", requested));
  return fail(requested != nullptr && *requested != '\0'
                  ? fmt::format("this processor lacks instructions of {}, which SHEAF_ISA requests", requested)
                  : "this processor lacks the required instructions of x86-64-v3 (AVX2, FMA, BMI; about 2013). Build "
                    "Sheaf from source to use it on this processor");
}
