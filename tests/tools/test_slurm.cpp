// `sheaf farm` on a real Slurm cluster of this machine alone, started by tools/farm/slurm.sh. Skipped with a message
// where the packages are missing or daemons cannot be started.
#include "core/image/exr.h"
#include "tests/support/parts_testing.h"
#include "tests/support/program_testing.h"

#include <doctest/doctest.h>

namespace sheaf::test_slurm {

namespace {

constexpr const char* kScene = R"(<scene version="3.0.0">
  <default name="frame" value="0"/>
  <integrator type="path"/>
  <sensor type="perspective">
    <float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="$frame,0,5" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="40"/></film>
    <sampler type="sobol"><integer name="sample_count" value="20000"/></sampler>
  </sensor>
  <shape type="sphere"><bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf></shape>
  <emitter type="constant"><rgb name="radiance" value="1"/></emitter>
</scene>)";

/// Submits a farm and stops three of its parts: one is requeued by Slurm, one loses its renderer, one exceeds its time
/// limit. Exits with 77 where there is no Slurm.
constexpr const char* kScript = R"sh(
set -u
slurm=$PWD/slurm
export SLURM_CONF=$slurm/slurm.conf
fail() { echo "FAILED: $*"; squeue; tail -n 20 *_farm/parts/*/*.log "$slurm"/slurmctld.log; exit 1; }
"$source_folder/tools/farm/slurm.sh" start "$slurm" || exit
trap '"$source_folder/tools/farm/slurm.sh" stop "$slurm"' EXIT
"$sheaf" farm "a scene.xml" --frames 1:2 --parts 4 -o "out.exr" --submit -- --no-timestamps --checkpoint-every 0.1 >jobs.txt ||
  fail "not submitted"
cat jobs.txt
read -r first joining < <(sed -n 's/^frame 1: parts are job \([0-9]*\), merging is job \([0-9]*\)$/\1 \2/p' jobs.txt)
parts=$PWD/"a scene_farm/parts/0001"
# In the middle: there is a checkpoint, and the job runs.
in_the_middle() {
  for ((i = 0; i < 2400; ++i)); do
    [[ ! -e $parts/$1.exr ]] || fail "part $1 was done before it could be stopped"
    [[ -e $parts/$1.state && $(squeue -h -j "${first}_$1" -o %T 2>/dev/null) == RUNNING ]] && return
    sleep 0.05
  done
  fail "part $1 has not begun"
}
in_the_middle 0
scontrol requeue "${first}_0" || fail "scontrol requeue"
in_the_middle 1
kill -KILL "$(pgrep -f -- "--output $parts/1.exr")" || fail "there is no render of part 1"
in_the_middle 2
scancel --batch --signal=TERM "${first}_2" || fail "scancel"
for ((i = 0; i < 2400; ++i)); do
  [[ -n $(squeue -h) ]] || break
  sleep 0.1
done
for part in 0 1 2; do
  scontrol show job "${first}_$part" | grep -q 'Restarts=1 ' || fail "part $part was not run twice"
done
[[ $(scontrol show job "${first}_3") == *Restarts=0* ]] || fail "part 3 was run twice"
[[ -e out_0001.exr && -e out_0002.exr ]] || fail "the images are not there"
"$sheaf" farm "a scene.xml" --parts 2 --denoise nlm -o denoised.exr --submit -- --spp 64 || fail "not submitted"
for ((i = 0; i < 600; ++i)); do
  [[ -n $(squeue -h) ]] || break
  sleep 0.1
done
[[ -e denoised.exr ]] || fail "there is no denoised image"
)sh";

}  // namespace

TEST_SUITE("slow") {
  TEST_CASE("farm: stopped parts resume and the images equal those of one run") {
    const TemporaryFolder folder;
    write_bytes(folder / "a scene.xml", kScene);
    write_bytes(folder / "go.sh", kScript);
    const std::string command = "cd '" + folder.path().string() +
                                "' && sheaf='" SHEAF_EXECUTABLE "' source_folder='" SHEAF_SOURCE_DIR
                                "' bash go.sh >log.txt 2>&1 </dev/null";
    const int status = std::system(command.c_str());
    const std::string log = read_bytes(folder / "log.txt");
    REQUIRE(WIFEXITED(status));
    if (WEXITSTATUS(status) == 77) {
      MESSAGE("skipped: " << log);
      return;
    }
    INFO(log);
    REQUIRE(WEXITSTATUS(status) == 0);
    const std::string killed = read_bytes(folder / "a scene_farm/parts/0001/1.log"),
                      timed_out = read_bytes(folder / "a scene_farm/parts/0001/2.log");
    CHECK(contains(killed, "was ended by signal 9"));
    CHECK(contains(timed_out, "was ended by signal 15"));
    CHECK(read_exr(folder / "denoised.exr").find_channel("denoised.R") >= 0);
    for (const std::string frame : {"1", "2"}) {
      CAPTURE(frame);
      REQUIRE(run(folder, "render 'a scene.xml' -D frame=" + frame + " --replicates 16 --quiet -o whole.exr").code ==
              0);
      check_near(read_exr(folder / ("out_000" + frame + ".exr")), read_exr(folder / "whole.exr"));
    }
  }
}

}  // namespace sheaf::test_slurm
