#include "tools/farm/farm_scripts.h"

#include "tools/options/process_command_line.h"

#include <fmt/format.h>

namespace sheaf {

namespace {

/// Assigns an array: name=('first word' 'second word').
std::string shell_array(std::string_view name, const std::vector<std::string>& words) {
  std::string text = std::string(name) + "=(";
  for (const std::string& word : words) text += (text.back() == '(' ? "" : " ") + shell_quoted(word);
  return text + ")\n";
}

std::string shell_variable(std::string_view name, std::string_view value) {
  return fmt::format("{}={}\n", name, shell_quoted(value));
}

/// First lines of both job scripts.
std::string job_start(const Farm& farm, const char* what) {
  return fmt::format("#!/usr/bin/env bash\n# Written by sheaf farm. {}\nset -u\n", what) +
         shell_variable("sheaf", farm.program) + shell_variable("folder", farm.folder) + "frame=$1\n" +
         (farm.has_frames ? "parts=$folder/parts/$(printf %04d \"$frame\")\n" : "parts=$folder/parts\n") +
         "mkdir -p -- \"$parts\" || exit 1\n";
}

}  // namespace

std::string render_script(const Farm& farm) {
  // Define the part and its options
  std::string text = job_start(farm, "Renders part SLURM_ARRAY_TASK_ID of frame $1.");
  text += "part=${SLURM_ARRAY_TASK_ID:?}\nexec >>\"$parts/$part.log\" 2>&1\n";
  text += fmt::format("cd -- {} || exit 1\n", shell_quoted(farm.working_folder));
  text += shell_variable("scene", farm.scene) + shell_array("options", farm.options) +
          shell_array("values", farm.part_values);
  if (farm.frame_rate)
    text += fmt::format("rate={:.17g}\n", double{*farm.frame_rate}) +
            R"sh(time=$(LC_ALL=C awk "BEGIN { printf \"%.17g\", $frame / $rate }") || exit 1
options+=(--time "$time")
)sh";
  else if (farm.has_frames)
    text += "options+=(--define \"frame=$frame\")\n";
  text += fmt::format("max_restarts={}\n", farm.max_restarts);
  // Render, and requeue the job if the render was stopped
  text += "options+=(" + farm.part_option + R"sh( "${values[part]}" --threads "${SLURM_CPUS_PER_TASK:-1}")
options+=(--output "$parts/$part.exr" --checkpoint "$parts/$part.state" --resume)
# Slurm signals only this shell before the time limit. Forward the signal, so that Sheaf writes a checkpoint and exits.
child=
trap 'kill -TERM "$child" 2>/dev/null' TERM
"$sheaf" render "$scene" "${options[@]}" &
child=$!
wait "$child"
code=$?
while kill -0 "$child" 2>/dev/null; do
  wait "$child"
  code=$?
done
# An interrupted wait returns the signal instead of the exit code of the render.
wait "$child" 2>/dev/null
again=$?
((again == 127)) || code=$again
((code > 128)) || exit "$code"
# The render was stopped or killed. Requeue the job unless Slurm has already canceled or requeued it.
job=${SLURM_ARRAY_JOB_ID}_$part
echo "sheaf farm: part $part of frame $frame was ended by signal $((code - 128)), after ${SLURM_RESTART_COUNT:-0} restarts"
if [[ $(squeue --noheader --jobs="$job" --format=%T) == RUNNING ]] && ((${SLURM_RESTART_COUNT:-0} < max_restarts)); then
  scontrol requeue "$job" && sleep 600
fi
exit "$code"
)sh";
  return text;
}

std::string merge_script(const Farm& farm) {
  std::string text = job_start(farm, "Merges the parts of frame $1.");
  text += "exec >>\"$parts/merge.log\" 2>&1\n";
  text += fmt::format("cd -- {} || exit 1\n", shell_quoted(farm.working_folder));
  text += fmt::format("files=()\nfor ((part = 0; part < {}; ++part)); do files+=(\"$parts/$part.exr\"); done\n",
                      farm.part_values.size());
  text += shell_array("options", farm.merge_options) + "outputs=()\n";
  for (const FrameName& output : farm.outputs) {
    text += "outputs+=(--output " + shell_quoted(output.texts.front());
    for (std::size_t i = 0; i < output.digits.size(); ++i)
      text += fmt::format("\"$(printf %0{}d \"$frame\")\"", output.digits[i]) + shell_quoted(output.texts[i + 1]);
    text += ")\n";
  }
  // Keep the checkpoints until the parts are merged: a restarted part then finishes immediately.
  if (farm.denoiser.empty())
    return text + R"sh("$sheaf" merge "${options[@]}" "${outputs[@]}" -- "${files[@]}" || exit
rm -f -- "$parts"/*.state
)sh";
  text += shell_variable("denoiser", farm.denoiser) + shell_array("denoise_options", farm.denoise_options);
  return text + R"sh(merged=$parts/merged.exr
"$sheaf" merge "${options[@]}" --output "$merged" -- "${files[@]}" || exit
denoise_options+=(--method "$denoiser" --threads "${SLURM_CPUS_PER_TASK:-1}")
"$sheaf" denoise "$merged" "${denoise_options[@]}" "${outputs[@]}" || exit
rm -f -- "$merged" "$parts"/*.state
)sh";
}

std::string submit_script(const Farm& farm, const std::string& render, const std::string& merge) {
  std::string text =
      "#!/usr/bin/env bash\n# Written by sheaf farm. Submits the jobs. Run it again to continue failed jobs.\n";
  text +=
      fmt::format("set -euo pipefail\n{}{}{}{}", shell_variable("render", render), shell_variable("merge", merge),
                  shell_array("options", farm.sbatch_options), shell_array("merge_options", farm.sbatch_merge_options));
  text += fmt::format("for ((frame = {}; frame <= {}; frame += {})); do\n", farm.frames.first, farm.frames.last,
                      farm.frames.step);
  text += fmt::format("  job=$(sbatch --parsable --array=0-{} \"${{options[@]}}\" \"$render\" \"$frame\")\n",
                      farm.part_values.size() - 1);
  text += R"sh(  job=${job%%;*}
  merging=$(sbatch --parsable --dependency="afterok:$job" --kill-on-invalid-dep=yes "${merge_options[@]}" "$merge" "$frame")
)sh";
  text += farm.has_frames ? "  echo \"frame $frame: parts are job $job, merging is job ${merging%%;*}\"\n"
                          : "  echo \"parts are job $job, merging is job ${merging%%;*}\"\n";
  return text + "done\n";
}

}  // namespace sheaf
