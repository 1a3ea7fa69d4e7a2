// Noise targets and denoising on the command line.
#include "core/image/exr.h"
#include "tests/support/program_testing.h"
#include "tests/tools/cli_scene.h"

#include <doctest/doctest.h>

namespace sheaf::test_cli_denoise {

using test::kScene;

TEST_CASE("a render stops at the noise target or at the time limit") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const Outcome clean = run(folder, "render scene.xml --noise-target 0.5 -v -o a.exr --stats a.json --no-timestamps");
  CHECK(clean.code == 0);
  CHECK(contains(clean.err, "tiles have enough samples for a noise of 50 %"));
  CHECK(contains(read_bytes(folder / "a.json"), "\"noise_target\": 0.5"));
  const std::string header = run(folder, "info a.exr").out;
  CHECK(contains(header, "sheaf/noiseTarget = 0.5"));
  CHECK(contains(header, "sheaf/noise = "));
  CHECK(contains(header, "variance.R"));
  CHECK(run(folder, "render scene.xml --time-limit 0.1 --checkpoint b.state -o b.exr").code == 0);
  CHECK(run(folder, "render scene.xml --time-limit 0.2 --checkpoint b.state --resume -o b.exr").code == 0);
  CHECK(run(folder, "render scene.xml --spp 256 --time-limit 1ms --checkpoint c.state -o c.exr").code == 0);
  const Outcome whole = run(folder, "render scene.xml --spp 256 --checkpoint c.state --resume -o c.exr");
  CHECK(whole.code == 0);
  CHECK(contains(whole.err, "256 spp on average"));
  for (const char* wrong : {"--noise-target 0", "--noise-target nan", "--time-limit -1", "--noise-target 0.1 --spp 3",
                            "--noise-target 0.1 --sampler stratified", "--time-limit 1 --integrator normals"}) {
    CAPTURE(std::string(wrong));
    CHECK(run(folder, std::string("render scene.xml -o c.exr ") + wrong).code == 2);
  }
}

TEST_CASE("an image is denoised while it is rendered or afterwards") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const Outcome rendered = run(folder, "render scene.xml --denoise nlm -o a.exr -o a.png --no-timestamps");
  CHECK(rendered.code == 0);
  const Image a = read_exr(folder / "a.exr");
  CHECK(a.find_channel("denoised.R") >= 0);
  CHECK(std::filesystem::exists(folder / "a.png"));
  CHECK(contains(run(folder, "info a.exr").out + read_bytes(folder / "a.exr"), "sheaf/denoiser"));
  CHECK(run(folder, "render scene.xml --replicates 4 --filter-mode importance -o noisy.exr --no-timestamps").code == 0);
  const Outcome after = run(folder, "denoise noisy.exr -o b.exr -o b.png");
  CHECK(after.code == 0);
  CHECK(contains(after.err, "nlm: "));
  const Image noisy = read_exr(folder / "noisy.exr"), b = read_exr(folder / "b.exr");
  for (std::size_t c = 0; c < noisy.channels.size(); ++c) {
    const int in_b = b.find_channel(noisy.channels[c]);
    REQUIRE(in_b >= 0);
    for (int y = 0; y < b.height; ++y)
      for (int x = 0; x < b.width; ++x) CHECK(b.at(x, y, in_b) == noisy.at(x, y, static_cast<int>(c)));
  }
  const ExrMetadata before = read_exr_metadata(folder / "noisy.exr"), now = read_exr_metadata(folder / "b.exr");
  CHECK(now.attributes.size() == before.attributes.size() + 1);
  CHECK(now.software == before.software);
  REQUIRE(now.world_to_camera.has_value());
  CHECK(now.world_to_camera->m == before.world_to_camera->m);
}

TEST_CASE("--denoise without a value takes the best denoiser of the machine, and says which") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  const Outcome chosen = run(folder, "render --denoise scene.xml -o a.exr");
  CHECK(chosen.code == 0);
  // As if the chosen one were given
  const bool has_oidn = contains(chosen.err, ", denoised by oidn; wrote a.exr");
  CHECK((has_oidn || contains(chosen.err, ", denoised by nlm; wrote a.exr")));
  CHECK(contains(read_bytes(folder / "a.exr"), has_oidn ? "oidn: features" : "nlm: two halves"));
  const Image a = read_exr(folder / "a.exr");
  CHECK((a.find_channel("half.R") < 0) == has_oidn);
  CHECK(!contains(run(folder, "render scene.xml -o b.exr").err, "denoised"));
}

TEST_CASE("--denoise nlm leaves the image itself unchanged") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  CHECK(run(folder, "render scene.xml --replicates 4 -o plain.exr").code == 0);
  CHECK(run(folder, "render scene.xml --replicates 4 --denoise nlm -o denoised.exr").code == 0);
  const Image plain = read_exr(folder / "plain.exr"), denoised = read_exr(folder / "denoised.exr");
  for (const char* name : {"R", "G", "B"})
    for (int y = 0; y < plain.height; ++y)
      for (int x = 0; x < plain.width; ++x)
        CHECK(denoised.at(x, y, denoised.find_channel(name)) == plain.at(x, y, plain.find_channel(name)));
}

TEST_CASE("images that cannot be denoised are errors with the reason") {
  const TemporaryFolder folder;
  write_bytes(folder / "scene.xml", kScene);
  CHECK(run(folder, "render scene.xml --sampler sobol --spp 4 -o bare.exr").code == 0);
  const Outcome bare = run(folder, "denoise bare.exr -o out.exr");
  CHECK(bare.code == 2);
  CHECK(contains(bare.err, "--replicates"));
  CHECK_FALSE(std::filesystem::exists(folder / "out.exr"));
  CHECK(run(folder, "denoise bare.exr").code == 2);
  CHECK(run(folder, "denoise bare.exr -o bare.exr").code == 2);
  CHECK(run(folder, "denoise bare.exr -o out.webp").code == 2);
  CHECK(run(folder, "denoise none.exr -o out.exr").code == 3);
  CHECK(run(folder, "denoise bare.exr -o none/out.exr").code == 4);
  CHECK(run(folder, "denoise bare.exr -o out.exr --method blur").code == 2);
  CHECK(run(folder, "render scene.xml --denoise nlm --spp 1 -o out.exr").code == 2);
  CHECK(run(folder, "render scene.xml --denoise nlm --replicates 1 -o out.exr").code == 2);
  const Outcome oidn = run(folder, "denoise bare.exr -o out.exr --method oidn");
  CHECK((oidn.code == 0 || (oidn.code == 1 && contains(oidn.err, "libOpenImageDenoise.so"))));
}

}  // namespace sheaf::test_cli_denoise
