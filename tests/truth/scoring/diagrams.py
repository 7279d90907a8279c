"""The benchmark's diagrams: how reliable stated probabilities are, and the confusion matrix."""

from pathlib import Path

import matplotlib
import numpy as np

from .score import clopper_pearson
from .tables import confusion

matplotlib.use("Agg")
from matplotlib import pyplot

EDGES = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 1.0)
INK, LINE, BAND = "#222222", "#1f5f99", "#9aa5b1"


def reliability(scored, folder, name="reliability"):
    """Share of right statements beside the probability that they state; nothing is drawn where none states one."""
    claims = [(one.probability, one.right) for one in scored if None not in (one.probability, one.right)]
    if not claims:
        return
    stated, right = np.array(claims, dtype=float).T
    which = np.clip(np.searchsorted(EDGES, stated, side="right") - 1, 0, len(EDGES) - 2)
    drawing, axes = pyplot.subplots(figsize=(6.4, 4.2), layout="constrained")
    labels = []
    for at, i in enumerate(sorted(set(which))):
        inside = which == i
        hits, cases = int(right[inside].sum()), int(inside.sum())
        low, high = clopper_pearson(hits, cases)
        axes.plot([at, at], [low, high], color=LINE, linewidth=1.5, zorder=2)
        axes.plot(at, hits / cases, "o", color=LINE, markersize=6, zorder=3, label="" if at else "right, 95 % interval")
        mean = stated[inside].mean()
        axes.plot([at - 0.3, at + 0.3], [mean, mean], color=BAND, linewidth=3.0, zorder=1, label="" if at else "stated")
        labels.append(f"{EDGES[i]:g}–{EDGES[i + 1]:g}\n{hits} of {cases}")
    axes.set_xticks(range(len(labels)), labels)
    axes.set(xlabel="stated probability; right of all that state it", ylabel="share", ylim=(0.0, 1.03))
    axes.set_title("Verdicts that claim something: stated and true", loc="left", fontsize=10)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(loc="lower right", frameon=False)
    save(drawing, folder, name)


def confusion_matrix(scored, folder):
    """What was hidden against what was said."""
    rows, columns, counts = confusion(scored)
    counts = np.array(counts)
    drawing, axes = pyplot.subplots(figsize=(2.6 + 0.28 * len(columns), 2.2 + 0.22 * len(rows)), layout="constrained")
    axes.imshow(np.where(counts > 0, np.log1p(counts), np.nan), cmap="Blues", vmin=0.0, aspect="auto")
    for i, j in np.argwhere(counts > 0):
        dark = counts[i, j] > 0.3 * counts.max()
        axes.text(j, i, counts[i, j], ha="center", va="center", fontsize=7, color="white" if dark else INK)
    axes.set_xticks(range(len(columns)), [name.replace("_", " ") for name in columns], rotation=90, fontsize=7)
    axes.set_yticks(range(len(rows)), [name.replace("_", " ") for name in rows], fontsize=7)
    axes.set(xlabel="said", ylabel="hidden")
    axes.set_xticks(np.arange(len(columns) + 1) - 0.5, minor=True)
    axes.set_yticks(np.arange(len(rows) + 1) - 0.5, minor=True)
    axes.grid(which="minor", color="#e6e9ed", linewidth=0.5)
    axes.tick_params(which="both", length=0)
    save(drawing, folder, "confusion")


def save(drawing, folder, name):
    """Save a drawing as PNG and PDF."""
    for kind in ("png", "pdf"):
        drawing.savefig(Path(folder) / f"{name}.{kind}", dpi=160)
    pyplot.close(drawing)
