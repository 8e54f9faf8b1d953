"""Measures raggio on the CPU beside other programs: `make bench`.

raggio and the others take turns, round after round, and what counts are ratios of one round: their median, the least and the
most. Everything that was measured goes to bench/results, with a plot. Machines should do nothing else meanwhile.
"""
import argparse
import json
import time

import matplotlib

import measures
import peers
import project


def table(rows):
    lines = ["| what | median | least | most |", "|---|---|---|---|"]
    return "\n".join(lines + [f"| {r['label']} | {r['median']:.2f} | {r['least']:.2f} | {r['most']:.2f} |" for r in rows])


def draw(rows, file):
    """Ratios with their ranges, on a logarithmic axis."""
    matplotlib.use("agg")
    from matplotlib import pyplot, ticker

    rows = [r for r in rows if not r.get("plain")][::-1]
    if not rows:
        return
    figure, axes = pyplot.subplots(figsize=(8, 1 + 0.3 * len(rows)))
    for y, r in enumerate(rows):
        axes.plot([r["least"], r["most"]], [y, y], color="tab:blue", linewidth=3, alpha=0.35, solid_capstyle="butt")
        axes.plot(r["ratios"], [y] * len(r["ratios"]), "|", color="tab:blue", markersize=7)
        axes.plot(r["median"], y, "o", color="tab:blue", markersize=5)
    axes.axvline(1, color="gray", linewidth=1)
    axes.set(xscale="log", yticks=range(len(rows)), yticklabels=[r["label"] for r in rows], xlabel="raggio, times the other")
    for axis in (axes.xaxis.set_major_formatter, axes.xaxis.set_minor_formatter):
        axis(ticker.FuncFormatter(lambda value, _: f"{value:g}"))
    axes.tick_params(axis="x", which="both", labelsize=7)
    axes.grid(axis="x", alpha=0.3)
    figure.savefig(file, bbox_inches="tight", dpi=110)


def main():
    parser = argparse.ArgumentParser(prog="bench", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="two rounds and few samples: a minute or two, to see that all runs")
    parser.add_argument("--all", action="store_true", help="growth up to rock 10, of 21 million triangles, not 8, of 1.3")
    parser.add_argument("--rounds", type=int, help="rounds that count [default: 5]")
    parser.add_argument("--only", nargs="+", choices=measures.MEASURES, default=list(measures.MEASURES), help="what to measure")
    parser.add_argument("--without", nargs="+", choices=peers.PEERS, default=[], help="programs to leave out")
    parser.add_argument("--no-build", action="store_true", help="take raggio as it was built last")
    options = parser.parse_args()
    options.rounds = options.rounds or (2 if options.quick else 5)
    options.shrink = 4 if options.quick else 1
    options.level = 10 if options.all else 8

    if not options.no_build:
        project.build()
    peers.install()
    about = project.machine()
    if about["load_before"] > 0.5:
        peers.say(f"other programs are running (load {about['load_before']:.1f}): figures will be off")
    available = peers.available(name for name in peers.PEERS if name not in options.without)

    folder = project.RESULTS / time.strftime("%Y%m%d-%H%M%S")
    folder.mkdir(parents=True)
    rows, detail, failed = [], {}, []
    start = time.perf_counter()
    for name in options.only:
        try:
            found, detail[name] = measures.MEASURES[name](options, available)
        except (peers.Failed, AssertionError) as reason:
            peers.say(f"{name} has failed: {reason}")
            failed.append(name)
            continue
        rows += found
        # After each part, so that what was measured is there whatever comes.
        report = {"machine": about, "peers": available, "options": vars(options), "rows": rows, "detail": detail,
                  "seconds": time.perf_counter() - start}
        (folder / "results.json").write_text(json.dumps(report, indent=1, default=str) + "\n")
    draw(rows, folder / "ratios.png")
    (folder / "table.md").write_text(table(rows) + "\n")
    print(f"\n{about['processor']}, {about['cores']} cores; {about['raggio']}; "
          f"{', '.join(dict.fromkeys(peer['name'] for peer in available.values()))}\n\n{table(rows)}\n")
    for part, unit in (("rates", "msamples_per_second"), ("traversal", "mrays_per_second"), ("start", "seconds")):
        figures = detail.get(part, {})
        named = figures.items() if part == "rates" else [(part, figures)]
        for name, found in named:
            values = ", ".join(f"{who} {value:.3g}" for who, value in found.get(unit, {}).items())
            if values:
                print(f"{name}, {unit.replace('_per_second', '/s')}: {values}")
    print(f"\n{folder.relative_to(project.ROOT)}: results.json, table.md, ratios.png")
    if failed:
        raise SystemExit(f"bench: {', '.join(failed)} failed")


if __name__ == "__main__":
    main()
