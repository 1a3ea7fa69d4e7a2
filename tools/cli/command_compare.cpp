// sheaf compare: differences between two images, with an exit status that depends on thresholds.
#include "core/image/image_compare.h"
#include "core/io/error.h"
#include "tools/cli/commands.h"
#include "tools/job/image_files.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <iterator>
#include <memory>
#include <optional>

namespace sheaf {

namespace {

struct CompareArguments {
  std::string a, b, variance_a, variance_b;
  unsigned spp = 1;
  double significance = 0.01;
  std::optional<double> max_mse, max_relative_mse, max_mean_ratio_error, min_accepted, min_mean_p;
};

/// Variance of an image: from `file`, divided by `spp`, or from the image's own layers if `file` is empty.
std::optional<Image> find_variance(const Image& image, const std::string& file, unsigned spp) {
  if (file.empty()) return variance_layers(image);
  check_is_image(file);
  Image variance = read_image(file);
  if (const std::optional<Image> layers = variance_layers(variance)) variance = *layers;
  for (float& value : variance.data) value /= static_cast<float>(spp);
  return variance;
}

std::string describe(const ImageComparison& result, const CompareOptions& options) {
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "compared       {} x {} pixels, channels", result.width, result.height);
  for (const std::string& channel : result.channels) fmt::format_to(out, " {}", channel);
  fmt::format_to(out, "\nMSE            {:.6g}\nrelative MSE   {:.6g}\n", result.mse, result.relative_mse);
  fmt::format_to(out, "mean ratio     {:.6f} ({:.6g} / {:.6g})\n", result.mean_ratio, result.mean_a, result.mean_b);
  if (result.non_finite > 0) fmt::format_to(out, "not finite     {} values, ignored\n", result.non_finite);
  if (!result.z_test) return text + "Z-test         no variances\n";
  const ZTest& test = *result.z_test;
  const char* source = options.variance_a && options.variance_b ? "both images"
                       : options.variance_a                     ? "the first image only"
                                                                : "the second image only";
  fmt::format_to(out,
                 "Z-test         {:.3f} % of {} values accepted at level {:g} (expected: {:.3f} %), mean z^2 {:.4f}, "
                 "variances of {}\n",
                 test.accepted_fraction() * 100, test.tests, test.significance, (1 - test.significance) * 100,
                 test.mean_z_squared, source);
  fmt::format_to(out, "equal means    p = {:.4g} (minimum over the channels, Bonferroni-corrected)\n",
                 test.corrected_mean_p());
  return text;
}

/// One line per exceeded threshold.
std::vector<std::string> find_failures(const ImageComparison& result, const CompareArguments& limits) {
  std::vector<std::string> failures;
  const auto require = [&failures](bool holds, const char* name, double value, const std::optional<double>& limit) {
    if (limit && !holds) failures.push_back(fmt::format("{} is {:.6g}, limit {:.6g}", name, value, *limit));
  };
  const auto below = [](double value, const std::optional<double>& limit) { return !limit || value <= *limit; };
  const auto above = [](double value, const std::optional<double>& limit) { return !limit || value >= *limit; };
  const double ratio_error = std::abs(result.mean_ratio - 1);
  require(below(result.mse, limits.max_mse), "MSE", result.mse, limits.max_mse);
  require(below(result.relative_mse, limits.max_relative_mse), "relative MSE", result.relative_mse,
          limits.max_relative_mse);
  require(below(ratio_error, limits.max_mean_ratio_error), "|mean ratio - 1|", ratio_error,
          limits.max_mean_ratio_error);
  if (result.z_test) {
    const double fraction = result.z_test->accepted_fraction(), p = result.z_test->corrected_mean_p();
    require(above(fraction, limits.min_accepted), "accepted share", fraction, limits.min_accepted);
    require(above(p, limits.min_mean_p), "p-value of equal means", p, limits.min_mean_p);
  }
  if (result.non_finite > 0) failures.push_back(fmt::format("{} values are not finite", result.non_finite));
  return failures;
}

int compare(const CompareArguments& arguments) {
  for (const std::string& file : {arguments.a, arguments.b}) check_is_image(file);
  const Image a = read_image(arguments.a), b = read_image(arguments.b);
  CompareOptions options;
  options.significance = arguments.significance;
  options.variance_a = find_variance(a, arguments.variance_a, arguments.spp);
  options.variance_b = find_variance(b, arguments.variance_b, arguments.spp);
  if ((arguments.min_accepted || arguments.min_mean_p) && !options.variance_a && !options.variance_b) {
    throw Error(ExitCode::kUsage,
                "--min-accepted and --min-mean-p need variances, but neither image has variance layers");
  }
  const ImageComparison result = compare_images(a, b, options);
  std::fputs(describe(result, options).c_str(), stdout);
  const std::vector<std::string> failures = find_failures(result, arguments);
  for (const std::string& failure : failures) print_message(failure);
  return static_cast<int>(failures.empty() ? ExitCode::kDone : ExitCode::kRuntime);
}

}  // namespace

void add_compare_command(Command& program, int& exit_code) {
  const auto arguments = std::make_shared<CompareArguments>();
  Command command = program.add_command(
      "compare",
      "Compare an image A with a reference B. The exit code is 0 if all given limits hold and all values are finite, "
      "otherwise 1. EXR values are compared as stored, 8-bit values after division by 255.");
  command.add_option("A", arguments->a, "Image").required().file();
  command.add_option("B", arguments->b, "Reference").required().file();
  command
      .add_option("--variance-a", arguments->variance_a,
                  "Image file with the variance of A. Default: the layers variance.R/G/B of A")
      .file();
  command
      .add_option("--variance-b", arguments->variance_b,
                  "Image file with the variance of B. Default: the layers variance.R/G/B of B")
      .file();
  command
      .add_option(
          "--spp", arguments->spp,
          "Divisor for variance files that hold the variance of single samples: the samples per pixel. Default: 1")
      .in_range(1u, 1u << 24);
  command
      .add_option("--significance", arguments->significance,
                  "Significance level of the Z-test of each value. Default: 0.01")
      .in_range(1e-12, 1.0 - 1e-12);
  command.add_option("--max-mse", arguments->max_mse, "Maximum mean squared error");
  command.add_option("--max-relmse", arguments->max_relative_mse,
                     "Maximum relative mean squared error, the mean of (a - b)^2 / (b^2 + 0.01)");
  command.add_option("--max-mean-ratio-error", arguments->max_mean_ratio_error, "Maximum of |mean(A) / mean(B) - 1|")
      .fraction();
  command
      .add_option("--min-accepted", arguments->min_accepted, "Minimum fraction of values that pass the Z-test, 0 to 1")
      .fraction()
      .in_range(0.0, 1.0);
  command.add_option("--min-mean-p", arguments->min_mean_p, "Minimum p-value of the test for equal means, 0 to 1")
      .in_range(0.0, 1.0);
  command.on_call([arguments, &exit_code] { exit_code = compare(*arguments); });
}

}  // namespace sheaf
