"""The page of a study: Markdown for the repository, and one HTML file that holds everything."""
import base64
import html
import textwrap
from dataclasses import dataclass

from . import convergence as orders
from . import pictures
from .cases import varied
from .charts import charts_of, draw
from .panels import finished, main_answer, points_of, series, shown
from .progress import duration

CSS = """body{font:15px/1.45 sans-serif;max-width:1200px;margin:2em auto;padding:0 1em}
table{border-collapse:collapse;font-size:13px}td,th{border:1px solid #ccc;padding:2px 7px;text-align:right}
td:first-child,th:first-child{text-align:left}img{max-width:100%}.failed td{color:#b00}small{color:#666}"""


def write(study, parts, results, folder, work):
    """Draws the parts and writes the pages of a study, Markdown and HTML. parts: cases by the name of their part;
    results: by key; work: folder of the runs. Returns the path of the HTML page."""
    sections = []
    for name, cases in parts.items():
        of_part = [results[case.key] for case in cases if case.key in results]
        if of_part:
            path = folder / study.stem_of(name)
            charts = [("", path)] if draw(study, study.parts[name], of_part, path) else []
            charts += pictures.draw(study, name, of_part, folder, work)
            sections.append(_section(study, name, of_part, len(cases), charts))
    (folder / f"{study.name}.md").write_text(_markdown(study, sections, results), encoding="utf-8")
    page = folder / f"{study.name}.html"
    page.write_text(_html(study, sections, results), encoding="utf-8")
    return page


@dataclass
class Section:
    """What both pages say of a part. charts: pairs of caption and path without ending; lines: below the table."""
    title: str
    text: str
    charts: list
    head: list
    rows: list
    results: list
    lines: list


def _section(study, name, results, n_cases, charts):
    part = study.parts[name]
    title = part.get("title", name)
    lines = convergence_lines(study, part, results) + failures(results) + notes(results)
    if n_cases > len(results):
        lines.append(f"{n_cases - len(results)} of {n_cases} runs are missing.")
    return Section(title, part.get("text", ""), charts, *table(study, part, results), results, lines)


def table(study, part, results):
    """Head and rows of the table of a part."""
    names = varied(study, [result.case for result in results])
    asked = part.get("columns") or list(study.answers)
    with_error = [name for name in asked if any(result.error(name) is not None for result in results)
                  and not _is_zero(results, name)]
    head = [study.label(name) for name in names] or ["run"]
    for name in asked:
        head += [study.label(name)] + (["error / %"] if name in with_error else [])
    counts = {} if study.command else {"steps": "steps", "cuts": "cuts", "Newton": "newton iterations",
                                       "points": "material points"}
    head += ["ended", "CPU time / s", "memory / MB", *counts]
    rows = []
    for result in results:
        row = [study.text(name, result.case.values[name]) for name in names] or ["default"]
        for name in asked:
            row.append(_number(result.answers.get(name), study.scale(name)))
            if name in with_error:
                error = result.error(name)
                row.append("-" if error is None else f"{100. * error:+.{2 if abs(error) < 0.1 else 3}g}")
        end = "" if result.reached is None else f" at {result.reached:.3g}"
        row.append(result.status if result.is_finished else f"**{result.status}**{end}")
        row += [f"{result.cpu:.3g}", f"{1e-6 * result.memory:.0f}",
                *(_number(result.costs.get(name), 1., "{:.0f}") for name in counts.values())]
        rows.append(row)
    return head, rows


def _is_zero(results, name):
    """Whether an answer should be zero, so that it is its own error."""
    return all(value == 0. for result in results for _, value in result.references.get(name, [])[:1])


def _number(value, scale=1., form="{:.4g}"):
    return "-" if value is None else form.format(value * scale)


def convergence_lines(study, part, results):
    """A sentence for each series of a convergence chart."""
    lines = []
    for chart in charts_of(study, part):
        if chart["kind"] != "convergence":
            continue
        answer, of_chart = main_answer(study, chart), shown(study, chart, results)
        for group in series(study, of_chart, chart["over"]):
            sizes, values = points_of(finished(group), chart["over"], answer)
            known = group[0].references.get(answer, [])
            text = []
            if (found := orders.richardson(sizes, values)) and chart.get("scales") != "log":
                text.append(found.text())
            elif chart.get("scales") == "log" and (order := orders.order_of_errors(sizes, values)):
                text.append(f"order {order:.2f}")
            if known and known[0][1] and (order := orders.order_of_errors(sizes, values / known[0][1] - 1.)):
                text.append(f"order of the error {order:.2f}")
            names = [name for name in varied(study, [r.case for r in of_chart]) if name != chart["over"]]
            which = ", ".join(f"{study.head_and_unit(name)[0]} {study.text(name, group[0].case.values[name])}"
                              for name in names)
            if text:
                lines.append(f"{study.label(answer)} over {study.label(chart['over'])}"
                             + (f" ({which})" if which else "") + f": {'; '.join(text)}.")
    return lines


def provenance(results):
    """Sentences that say where the numbers come from."""
    def all_of(name):
        return ", ".join(sorted({str(result.provenance[name]) for result in results.values()}))

    total = sum(result.cpu for result in results.values())
    commits = {result.provenance["commit"] for result in results.values()}
    return (f"{len(results)} runs, {duration(total)} of CPU time. Program: commit {all_of('commit')}"
            f"{' (mixed)' if len(commits) > 1 else ''}; machine: {all_of('machine')}; ranks: {all_of('ranks')}; "
            f"{all_of('date')}.")


def failures(results):
    """A line for each run that failed."""
    return [f"{result.case.name}: {result.status}" + (f" at {result.reached:.4g}" if result.reached is not None else "")
            + f": {result.message}" for result in results if not result.is_finished]


def notes(results):
    """A line for each answer that a run does not have though its curve is there."""
    return [f"{result.case.name}: {note}" for result in results for note in result.notes]


def _markdown(study, sections, results):
    text = f"# {study.title}\n\n{_wrapped(study.question)}\n"
    if study.source:
        text += f"\n{_wrapped(f'Reference: {study.source}')}\n"
    for section in sections:
        text += f"\n## {section.title}\n\n"
        text += _wrapped(section.text) + "\n\n" if section.text else ""
        for caption, chart in section.charts:
            text += _wrapped(f"![{caption or section.title}]({chart.name}.png)") + "\n\n"
        lines = [section.head, ["---"] * len(section.head), *section.rows]
        text += "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"
        if section.lines:
            text += "\n" + "\n".join(_wrapped(f"- {line}", "  ") for line in section.lines) + "\n"
    return text + f"\n{_wrapped(provenance(results))}\n"


def _wrapped(text, indent=""):
    """Text in lines of at most 120 characters."""
    return textwrap.fill(text, 120, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def _picture(chart, text):
    """A picture inside the page."""
    file, kind = chart.with_suffix(".svg"), "svg+xml"
    if not file.is_file():
        file, kind = chart.with_suffix(".png"), "png"
    data = base64.b64encode(file.read_bytes()).decode()
    return f'<img alt="{html.escape(text)}" src="data:image/{kind};base64,{data}">'


def _html(study, sections, results):
    def cell(text, tag):
        return f"<{tag}>{html.escape(text.replace('**', ''))}</{tag}>"

    body = f"<h1>{html.escape(study.title)}</h1><p>{html.escape(study.question)}</p>"
    if study.source:
        body += f"<p>Reference: {html.escape(study.source)}</p>"
    for section in sections:
        body += f"<h2>{html.escape(section.title)}</h2><p>{html.escape(section.text)}</p>"
        for caption, chart in section.charts:
            body += f"<p>{_picture(chart, caption or section.title)}<br>{html.escape(caption)}</p>"
        body += "<table><tr>" + "".join(cell(text, "th") for text in section.head) + "</tr>"
        for result, row in zip(section.results, section.rows):
            body += (f"<tr{'' if result.is_finished else ' class=failed'}>" + "".join(cell(text, "td") for text in row)
                     + "</tr>")
        body += "</table>"
        if section.lines:
            body += "<ul>" + "".join(f"<li>{html.escape(line)}</li>" for line in section.lines) + "</ul>"
    runs = "".join(f"<tr>{cell(result.case.name, 'td')}{cell(result.provenance['commit'], 'td')}"
                   f"{cell(result.provenance['input'], 'td')}{cell(str(result.provenance['ranks']), 'td')}"
                   f"{cell(result.provenance['machine'], 'td')}{cell(f'{result.cpu:.4g}', 'td')}</tr>"
                   for result in results.values())
    body += (f"<h2>Runs</h2><p><small>{html.escape(provenance(results))}</small></p><table><tr><th>run</th>"
             f"<th>commit</th><th>input</th><th>ranks</th><th>machine</th><th>CPU time / s</th></tr>{runs}</table>")
    return (f"<!doctype html><html lang=en><meta charset=utf-8><title>{html.escape(study.title)}</title>"
            f"<style>{CSS}</style><body>{body}</body></html>\n")
