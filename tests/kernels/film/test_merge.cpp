// Images of parts, split by tiles or by samples, merged into the image of the whole render.
#include "kernels/film/merge.h"

#include "core/io/error.h"
#include "core/sampling/rng.h"
#include "kernels/film/film.h"
#include "kernels/film/noise.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>

namespace sheaf::test_merge {

namespace {

constexpr int kFrameWidth = 19, kFrameHeight = 13;
constexpr std::uint32_t kSets = 6, kPerSet = 2, kSamples = kSets * kPerSet;
constexpr int kShapes = 5;

const FilmLayout kLayout({{"R", true, true}, {"G", true}, {"B", true}, {"N.X", false}});
const AovSet kAovs{aov_named("object_id"), aov_named("cryptomatte_object"), aov_named("material_id")};

/// Five shapes with four object names and three material names.
SceneNames some_names() {
  SceneNames names;
  names.objects = {"wall", "ball", "lamp", "floor"};
  names.materials = {"paint", "glass", "default"};
  names.object_of_shape = {0, 1, 1, 2, 3};
  names.material_of_shape = {2, 0, 1, 0, 1};
  return names;
}

/// The image of `samples`, a range of whole sample sets, in `crop`. `part`: includes all channels that merging needs.
Image image_of(const FilterWeights* weights, const PixelRect& crop, const SampleRange& samples, bool part) {
  const int reach = weights != nullptr ? weights->reach() : 0;
  const PixelRect requested = crop.grown(reach).intersection({0, 0, kFrameWidth, kFrameHeight});
  Film film(kFrameWidth, kFrameHeight, crop, kLayout, 3, VarianceUnit::kReplicate, true);
  for (std::uint32_t first = samples.first; first < samples.end(); first += kPerSet) {
    FilmTile tile;
    film.begin(tile, {0, 0, kFrameWidth, kFrameHeight}, weights);
    SampleBuffer drawn;
    drawn.resize(1, kLayout.size(), true, true);
    for (int y = requested.y0; y < requested.y1; ++y)
      for (int x = requested.x0; x < requested.x1; ++x)
        for (std::uint32_t i = first; i < first + kPerSet; ++i) {
          const auto pixel = static_cast<std::uint32_t>(y * kFrameWidth + x);
          const auto u = random4<Scalar>(3, pixel, i, 0), v = random4<Scalar>(3, pixel, i, 1);
          drawn.offset(0) = {u.x - 0.5f, u.y - 0.5f};
          const float values[] = {u.z * static_cast<float>(1 + x % 5), 3.0f, v.x * v.x * v.x * 100.0f, v.y - 0.5f};
          std::memcpy(drawn[0], values, sizeof values);
          drawn.spectrum(0) = {{0, 1, 1, 2}, {u.z, 0.5f, 0.25f, v.x}};
          const auto shape = static_cast<std::uint32_t>(v.z * (kShapes + 1));
          drawn.surface(0) = {shape < kShapes ? shape : IdCoverage::kNothing, 1};
          tile.add(x, y, drawn, 0, 1);
        }
    film.add(tile);
    film.add(std::vector<FilmBorder>{tile.border()});
    film.end_replicate();
    if (2 * (first + kPerSet) == kSamples || (2 * samples.end() < kSamples && first + kPerSet == samples.end()))
      film.end_first_half();
  }
  Image image = film.to_image();
  if (part) film.add_part_layers(image);
  add_id_layers(kAovs, some_names(), film, image);
  if (part) add_part_ids(kAovs, some_names(), film, image);
  return image;
}

std::array<std::vector<float>, kNameKinds> some_ids() {
  const auto attributes = part_id_attributes(kAovs, some_names());
  REQUIRE(attributes.size() == 1);
  CHECK(attributes[0].first == part_id_attribute(0));
  return {*ids_from_attribute(attributes[0].second), {}};
}

/// Merges parts. The result has no channels for further merging.
Image joined(const FilterWeights* weights, const std::vector<ImagePart>& parts) {
  const PixelRect frame{0, 0, kFrameWidth, kFrameHeight};
  const std::vector<std::string> channels = image_of(weights, {0, 0, 1, 1}, {0, kPerSet}, false).channels;
  ImageMerger merger(kFrameWidth, kFrameHeight, frame, channels, kSamples, some_ids());
  check_overlaps(parts);
  CHECK(!find_gap(parts, frame, kSamples));
  for (const ImagePart& part : parts)
    merger.add(part, image_of(weights, part.pixels, part.samples, part.samples.count < kSamples));
  return merger.finish();
}

/// Checks that all values are equal up to rounding of the parts' values to floats.
void check_near(const Image& found, const Image& expected) {
  REQUIRE(found.channels == expected.channels);
  for (std::size_t c = 0; c < found.channels.size(); ++c) {
    const std::string& name = found.channels[c];
    const int i = static_cast<int>(c);
    double largest = 0, worst = 0;
    bool same = true;
    for (int y = 0; y < kFrameHeight; ++y)
      for (int x = 0; x < kFrameWidth; ++x)
        largest = std::max(largest, std::fabs(static_cast<double>(expected.at(x, y, i))));
    for (int y = 0; y < kFrameHeight; ++y)
      for (int x = 0; x < kFrameWidth; ++x) {
        const double a = found.at(x, y, i), b = expected.at(x, y, i);
        same = same && found.at(x, y, i) == expected.at(x, y, i);
        // Sums of values with both signs may cancel; G is constant.
        worst = std::max(worst, std::fabs(a - b) / (std::fabs(b) + 0.02 * largest + 1e-6));
      }
    CAPTURE(name);
    CAPTURE(worst);
    const bool is_exact = name == "sampleCount" || name.ends_with("Id") ||
                          (name.starts_with("Crypto") && (name.ends_with("r") || name.ends_with("b")));
    if (is_exact)
      CHECK(same);
    else
      CHECK(worst < 2e-6);
    if (!name.starts_with("CryptoObject02") && name != "variance.G") CHECK(largest > 0);
  }
}

PixelRect frame_part(int x0, int y0, int x1, int y1) { return {x0, y0, x1, y1}; }

}  // namespace

TEST_CASE("merge: merged sample ranges approximate the whole for every filter and merged tiles equal it") {
  PixelFilter mitchell, gaussian;
  mitchell.kind = PixelFilter::Kind::kMitchell;
  gaussian.kind = PixelFilter::Kind::kGaussian;
  const FilterWeights of_mitchell(mitchell), of_gaussian(gaussian);
  const PixelRect frame = frame_part(0, 0, kFrameWidth, kFrameHeight), left_part = frame_part(0, 0, 8, kFrameHeight),
                  right_part = frame_part(8, 0, kFrameWidth, kFrameHeight);
  for (const FilterWeights* weights : {static_cast<const FilterWeights*>(nullptr), &of_gaussian, &of_mitchell}) {
    CAPTURE(weights == &of_mitchell);
    const Image whole = image_of(weights, frame, {0, kSamples}, false);
    check_near(
        joined(weights, {{"a", frame, {0, 2}}, {"b", frame, {2, 2}}, {"c", frame, {4, 2}}, {"d", frame, {6, 6}}}),
        whole);
    // Single sets: parts that have no variance of their own.
    std::vector<ImagePart> sets;
    for (std::uint32_t set = kSets; set > 0; --set) sets.push_back({"set", frame, {(set - 1) * kPerSet, kPerSet}});
    check_near(joined(weights, sets), whole);
    check_near(joined(weights, {{"a", left_part, {0, kSamples}}, {"b", right_part, {4, 8}}, {"c", right_part, {0, 4}}}),
               whole);
    const Image tiles = joined(weights, {{"a", left_part, {0, kSamples}}, {"b", right_part, {0, kSamples}}});
    CHECK(tiles.channels == whole.channels);
    CHECK(std::memcmp(tiles.data.data(), whole.data.data(), whole.data.size() * sizeof(float)) == 0);
    CHECK(image_noise(tiles) == image_noise(whole));
  }
}

TEST_CASE("merge: overlapping parts are rejected and gaps are found") {
  const PixelRect frame = frame_part(0, 0, 10, 10), top = frame_part(0, 0, 10, 4), bottom = frame_part(0, 4, 10, 10);
  const auto throws = [](std::vector<ImagePart> parts) { CHECK_THROWS_AS(check_overlaps(parts), SceneError); };
  throws({{"a", frame, {0, 8}}, {"b", frame, {7, 1}}});
  throws({{"a", top, {0, 8}}, {"b", frame_part(9, 3, 10, 9), {0, 8}}});
  throws({{"a", top, {0, 8}}, {"a", top, {0, 8}}});
  try {
    check_overlaps(std::vector<ImagePart>{{"a.exr", frame, {0, 8}}, {"b.exr", frame_part(3, 2, 4, 3), {4, 8}}});
    CHECK(false);
  } catch (const SceneError& error) {
    CHECK(std::string(error.what()) == "b.exr: shares samples with 'a.exr': 4:4 of pixel 3,2");
  }
  const std::vector<ImagePart> parts{{"a", top, {0, 8}},
                                     {"b", bottom, {0, 3}},
                                     {"c", frame_part(0, 4, 5, 10), {3, 5}},
                                     {"d", frame_part(5, 4, 10, 9), {3, 5}}};
  CHECK_NOTHROW(check_overlaps(parts));
  const auto gap = find_gap(parts, frame, 8);
  REQUIRE(gap);
  CHECK(gap->pixels == frame_part(5, 9, 10, 10));
  CHECK(gap->samples == SampleRange{3, 5});
  CHECK(covered_fraction(parts, frame, 8) == near(1.0 - 5.0 * 5 / 800));
  CHECK(!find_gap(parts, frame_part(0, 0, 10, 9), 8));
  const auto end = find_gap(std::vector<ImagePart>{{"a", frame, {0, 8}}}, frame, 9);
  REQUIRE(end);
  CHECK(end->samples == SampleRange{8, 1});
}

TEST_CASE("merge: parts with missing layers or impossible headers are rejected") {
  const PixelRect frame = frame_part(0, 0, kFrameWidth, kFrameHeight);
  const Image whole = image_of(nullptr, frame, {0, kSamples}, false);
  const Image part = image_of(nullptr, frame, {0, 6}, true);
  const ImagePart of{"a.exr", frame, {0, 6}};
  const auto merger = [&] {
    return ImageMerger(kFrameWidth, kFrameHeight, frame, whole.channels, kSamples, some_ids());
  };
  CHECK_NOTHROW(merger().add(of, part));
  CHECK_THROWS_AS(merger().add(of, whole), SceneError);
  CHECK_THROWS_AS(merger().add({"a.exr", frame_part(0, 0, 5, 5), {0, 6}}, part), SceneError);
  for (const std::string& name : part.channels) {
    CAPTURE(name);
    Image renamed = part;
    const auto at = static_cast<std::size_t>(part.find_channel(name));
    renamed.channels[at] = "x." + name;
    CHECK_THROWS_AS(merger().add(of, renamed), SceneError);
    if (!name.starts_with("part.")) continue;
    CHECK(is_left_out(name));
    CHECK(!missing_part_layer(renamed).empty());
  }
  CHECK(missing_part_layer(part).empty());
  const int number = part.find_channel("part.object.number0");
  for (const float wrong : {-1.0f, 0.5f, 1.5f, 1e9f, std::nanf(""), -INFINITY}) {
    Image damaged = part;
    damaged.at(3, 2, number) = wrong;
    CHECK_THROWS_AS(merger().add(of, damaged), SceneError);
  }
  // A number without an id in the header.
  Image damaged = part;
  damaged.at(3, 2, number) = 5;
  ImageMerger last = merger();
  last.add(of, damaged);
  CHECK_THROWS_AS(last.finish(), SceneError);
  CHECK(!ids_from_attribute("0123456"));
  CHECK(!ids_from_attribute("0123456x"));
  CHECK(ids_from_attribute("3f800000bf800000") == std::vector<float>{1, -1});
}

}  // namespace sheaf::test_merge
