"""Writes docs/performance.md and its plot."""

import textwrap
from statistics import geometric_mean, mean, median

from renderers.errors import efficiency_ratio, figure, speed_ratio
from renderers.plot import write_plot
from renderers.programs import TwinRenderer
from twins.scenes import SCENES

INTRODUCTION = """# Performance

`bench/compare_renderers.py` wrote this page from one run. It renders each scene with Sheaf and with other renderers,
one after the other, and compares their errors and times:

```
{makers}bench/compare_renderers.py --mitsuba-python ENVIRONMENT/bin/python --cycles-python ENVIRONMENT/bin/python \\
  --luxcore-python ENVIRONMENT/bin/python --markdown docs/performance.md
```

Without `--markdown` it prints times, errors and ratios only. [bench/README.md](../bench/README.md) says how to install
Cycles and LuxCore. Other scenes, of Mitsuba or of pbrt-v4:

```
bench/compare_renderers.py --scenes scenes/mesh_box/mesh_box.xml -D width=400 -D height=300 --spp 32
bench/compare_renderers.py --scenes scenes/cornell/cornell.pbrt --pbrt PROGRAM
```

| | |
| --- | --- |
{machine}
"""

METHOD = """## Method

Sheaf, Mitsuba and pbrt-v4 read the same file, Cycles and LuxCore the description of the twin scenes. All take {spp} spp
with {threads}. In each of {runs} rounds, every renderer renders once, with a new seed. Other programs may run on the
machine, so single times scatter; renderers that alternate are disturbed alike. Times and their ratios are medians over
the rounds, errors are means. Parentheses hold the smallest and the largest value of a round.

- **rendering**: wall time of the samples alone, without reading or building the scene. For Mitsuba's `llvm_ad_rgb` and
  for Cycles it is that of the second image of a process, because the first one loads kernels or builds the scene.
  Cycles synchronizes the scene before every image, so the time of an image with 1 spp is subtracted from that of
  all samples, and the remainder scaled to all samples.
- **CPU**: user and system time of all threads. For Mitsuba it covers the call that renders, for Cycles and LuxCore the
  time of rendering; for Sheaf and pbrt-v4 the whole process, scene included.
- **process**: wall time from the start of a process to its first image. Sheaf's includes writing the file.
- **MSE**: mean squared error over pixels and channels.
- **relative MSE**: the squared error over a^2 + 0.01 m^2 for a pixel value a and the mean m of the reference. It leaves
  out the largest 0.1 %. Few bright pixels rule the MSE, and all pixels the relative MSE.
- **mean**: the mean of all images over that of the reference, with its standard error.
- **reference**: the error is measured against two independent renders by Sheaf with {reference_spp} spp each, as the
  mean of (x - a) (x - b), which is free of their noise. If a renderer converges to another image, that difference is
  not counted as noise: "own" marks errors that are measured against the mean of the renderer's other images. This is
  so if its mean is off by more than 0.5 % and 3 standard errors, or if more than a tenth of its squared error
  against Sheaf's reference is not noise.
"""

EFFICIENCY = """## Time to equal error

Squared error is inversely proportional to time, so the error times the time of a renderer over that of Sheaf is the
factor by which it takes longer to the same error. Above 1, Sheaf is faster. Lines that begin with Sheaf compare other
options of Sheaf with the default.
"""

TWINS = """## Twin scenes

`bench/twins` describes these scenes once and builds them for each renderer, of models that all share: Lambertian
surfaces, conductors with GGX microfacets, smooth glass, lights, and an isotropic homogeneous medium. All meshes are
flat-shaded. Sheaf's `max_depth` of 64 equals Cycles' 62 bounces. Filters are boxes of 1 pixel. Light is not clamped,
images are not denoised, and all pixels take the same samples. Everything else is each renderer's default. Mitsuba is
left out, because its compiling variant takes minutes for thousands of instances.

The table shows the mean of all images over that of Sheaf's reference, with its standard error. A renderer whose mean is
off by more than 3 % is not compared.
"""

DIFFERENCES = """## Differences by design

- **Samples.** Sheaf replaces the sampler `independent` by Owen-scrambled Sobol points. Mitsuba has no such sampler.
  The lines `--sampler independent` show how much of the difference comes from this. Cycles and LuxCore use Sobol
  points.
- **Lights.** Sheaf selects lights by a light BVH and, in `hall`, resamples 4 candidates; Mitsuba selects uniformly,
  Cycles by a light tree, LuxCore by power.
- **Russian roulette.** Sheaf starts it at depth 2, or 5 in scenes with media, and restores the throughput of
  survivors to 1/2; Mitsuba starts it at depth 5, LuxCore at depth 3.
- **Media.** Sheaf's `volpath` combines wavelengths by null-scattering multiple importance sampling; Mitsuba's
  uses delta tracking by one channel.
- **Execution.** Sheaf's stages work on private queues of about a thousand paths per thread. Mitsuba's `llvm_ad_rgb`
  renders a whole image as one wavefront in memory, and compiles its kernels for the scene; `scalar_rgb` traces
  path by path.
- **Color.** Sheaf, Mitsuba, Cycles and LuxCore render in linear Rec. 709. For scenes of pbrt-v4, Sheaf and pbrt-v4
  render spectrally.
- **Filters.** Sheaf and Mitsuba let a sample count in all pixels under the pixel filter.
"""


def table(head, lines):
    return "\n".join(f"| {' | '.join(cells)} |" for cells in [head, ["---"] * len(head), *lines]) + "\n"


def paragraph(text):
    return textwrap.fill(text, 120, break_on_hyphens=False, break_long_words=False) + "\n"


def code(program):
    """The name of a program, with its variant or options as code."""
    name, *options = program.split(" ", 1)
    return f"{name} `{options[0]}`" if options else name


def spread(values, digits=2):
    """Median, minimum and maximum in seconds."""
    return f"{median(values):.{digits}f} ({min(values):.{digits}f} to {max(values):.{digits}f})"


def megabytes(value):
    return f"{value / 1e6:.0f} MB"


def mean_cell(m):
    return f"{m.errors.mean_ratio:.4f} ± {m.errors.mean_uncertainty:.4f}"


def measures_cells(name, m):
    return [name, code(m.program), spread(m.times()), spread(m.times("cpu_seconds")),
            f"{m.time('process_seconds'):.2f}", f"{m.mse:.2e}", f"{mean(m.errors.relative):.2e}",
            mean_cell(m), "own" if m.errors.is_own else "Sheaf"]


def measures_section(results):
    lines = [measures_cells(name if i == 0 else "", m) for name, of_scene in results.items()
             for i, m in enumerate(of_scene)]
    head = ["scene", "renderer", "rendering, s", "CPU, s", "process, s", "MSE", "relative MSE", "mean", "reference"]
    return "## Times and errors\n\n" + table(head, lines)


def cpu_ratios(ours, other):
    """Error times CPU time over ours, by MSE and by relative MSE."""
    return [efficiency_ratio(ours, other, error, "cpu_seconds").value for error in ("mse", "relative")]


def mean_figure(ratios):
    """Geometric mean, if the noise of the references made no error negative."""
    return figure(geometric_mean(ratios)) if min(ratios) > 0 else "unknown"


def efficiency_section(results):
    """The ratios of each other renderer, and what its first process took."""
    lines, by_program = [], {}
    for name, (ours, *others) in results.items():
        for i, m in enumerate(others):
            by_program.setdefault(m.program, []).append(cpu_ratios(ours, m))
            lines.append([name if i == 0 else "", code(m.program), str(efficiency_ratio(ours, m)),
                          str(efficiency_ratio(ours, m, "relative")), *map(figure, cpu_ratios(ours, m)),
                          str(speed_ratio(ours, m))])
    if not lines:
        return EFFICIENCY + "\nThis run measured no other renderer.\n"
    head = ["scene", "compared with", "by MSE", "by relative MSE", "by MSE and CPU time",
            "by relative MSE and CPU time", "time per sample"]
    means = [[code(program), str(len(ratios)), *map(mean_figure, zip(*ratios))]
             for program, ratios in by_program.items()]
    parts = [EFFICIENCY, table(head, lines), "Geometric means over the scenes that a renderer shares with Sheaf:\n",
             table(["compared with", "scenes", *head[4:6]], means)]
    compiled = [f"{m.first_process_seconds:.0f} s ({name})" for name, of_scene in results.items() for m in of_scene
                if "llvm" in m.program]
    if compiled:
        parts.append(paragraph("The first process of `llvm_ad_rgb` per scene, which compiles, is not in these figures. "
                               f"It took {', '.join(compiled)} to its first image."))
    return "\n".join(parts)


def scaling_section(name, scaling, threads):
    """Speed by threads. CPU time shows the cost of sharing caches and memory even if other programs run."""
    counts = list(next(iter(scaling.values())))
    lines = []
    for program, by_count in scaling.items():
        seconds = {n: min(r.seconds for r in renders) for n, renders in by_count.items()}
        cpu = {n: min(r.cpu_seconds for r in renders) for n, renders in by_count.items()}
        peak = {n: max(r.peak_bytes for r in renders) for n, renders in by_count.items()}
        one = counts[0]
        for n in counts:
            lines.append([code(program) if n == one else "", str(n), spread([r.seconds for r in by_count[n]]),
                          f"{seconds[one] / seconds[n]:.2f}", f"{cpu[n] / cpu[one]:.2f}", megabytes(peak[n])])
    head = ["renderer", "threads", "rendering, s", "speed-up", "CPU time over that of 1 thread", "peak memory"]
    text = paragraph(f"`{name}`, with up to {threads} threads. Threads of Sheaf share the scene and the film, and each "
                     "has queues of its own. Speed-up and CPU time are those of the fastest rounds. CPU time stays "
                     "the same if threads do not slow each other down. Other programs that take part of the cores "
                     "reduce the speed-up, but hardly change the CPU time.")
    return "\n".join(["## Thread scaling\n", text, table(head, lines)])


def memory_section(results):
    programs = list(dict.fromkeys(m.program for of_scene in results.values() for m in of_scene))
    programs = [p for p in programs if not p.startswith("Sheaf ")]
    lines = []
    for name, of_scene in results.items():
        peaks = {m.program: megabytes(m.peak_bytes) for m in of_scene}
        lines.append([name, *(peaks.get(program, "") for program in programs)])
    text = paragraph("Peak resident memory of the process: the largest of all rounds, as the system reports it. "
                     "Those of Mitsuba, Cycles and LuxCore include the Python interpreter.")
    return "\n".join(["## Memory\n", text, table(["scene", *map(code, programs)], lines)])


def stages_section(name, ours):
    """Fractions of the time of all workers of Sheaf by stage, as means over the rounds."""
    reports = [render.report for render in ours.renders]
    workers = mean(report["render_seconds"] * report["threads"] for report in reports)
    shares, items = {}, {}
    for stage in reports[0]["stages"]:
        found = [next(s for s in report["stages"] if s["name"] == stage["name"]) for report in reports]
        shares[stage["name"]] = mean(s["seconds"] for s in found) / workers
        items[stage["name"]] = mean(s["ns_per_item"] for s in found)
    shown = sorted((s for s in shares if shares[s] >= 0.01), key=lambda s: -shares[s])
    lines = [[f"`{stage}`", f"{shares[stage]:.0%}", f"{items[stage]:.0f} ns"] for stage in shown]
    small = sum(share for stage, share in shares.items() if stage not in shown)
    lines.append(["other stages", f"{small:.0%}", ""])
    lines.append(["outside of the stages", f"{max(0, 1 - sum(shares.values())):.0%}", ""])
    embree = mean(report["trace_share"] for report in reports)
    rays = mean(report["rays_per_second"] for report in reports) / 1e6
    text = paragraph(f"Fractions of the worker time that Sheaf spends on `{name}`, from `--stats`. Embree takes "
                     f"{embree:.0%}, inside `intersect` and `shadow`, at {rays:.1f} million rays per second. Outside "
                     "of the stages are the pixel filter, and the time in which workers wait for the last tiles. "
                     "[architecture.md](architecture.md) describes the stages.")
    return "\n".join(["## Cost of the stages\n", text, table(["stage", "time", "per item"], lines)])


def curves_section(arguments, curves):
    if not curves:
        return ""
    plot = arguments.markdown.with_suffix(".svg")
    write_plot(plot, curves)
    spp = ", ".join(str(n) for n in arguments.curve_spp)
    return "\n".join(["## Error over time\n", f"![Relative mean squared error over time]({plot.name})\n", paragraph(
        f"Relative MSE over the wall time of rendering, of the fastest round, at {spp} spp, with logarithmic axes. The "
        "numbers at Sheaf's points are its samples per pixel.")])


def twins_section(comparison, results):
    """The twin scenes, and whether the renderers agree about them."""
    scenes = [scene for scene in comparison.scenes if scene.twin]
    programs = [p.name for p in comparison.others if isinstance(p, TwinRenderer)]
    if not scenes:
        return ""
    lines = []
    for scene in scenes:
        means = {m.program: mean_cell(m) for m in results[scene.name]}
        lines.append([scene.name, SCENES[scene.twin].__doc__, *(means.get(p, "not compared") for p in programs)])
    return TWINS + "\n" + table(["scene", "contents", *programs], lines)


def notes_text(comparison):
    """What was not measured, and what other renderers ignore."""
    parts = [f"{note}." for note in comparison.notes]
    ignored = {}
    for program in comparison.others:
        for scene, names in getattr(program, "ignored", {}).items():
            ignored.setdefault((scene, tuple(names)), []).append(code(program.name))
    for (scene, names), programs in ignored.items():
        parts.append(f"{' and '.join(programs)} ignore {' and '.join(f'`{n}`' for n in names)} in `{scene}`.")
    return paragraph(" ".join(parts)) if parts else ""


def write_page(arguments, comparison, facts, results, sections):
    """`results`: {scene: measurements}. `sections`: those between the efficiency and the memory."""
    origins = {scene.file.parent / "generated.txt" for scene in comparison.scenes}
    makers = sorted({path.read_text().split()[1] for path in origins if path.exists()})
    threads = f"{arguments.threads} threads" if arguments.threads != 1 else "1 thread"
    parts = [
        INTRODUCTION.format(makers="".join(f"{maker}\n" for maker in makers),
                            machine="\n".join(f"| {what} | {text} |" for what, text in facts)),
        notes_text(comparison),
        METHOD.format(spp=arguments.spp, threads=threads, runs=arguments.runs, reference_spp=arguments.reference_spp),
        measures_section(results), twins_section(comparison, results), efficiency_section(results), *sections,
        memory_section(results)]
    arguments.markdown.write_text("\n".join(part for part in parts if part), encoding="utf-8")
