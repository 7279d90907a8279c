"""The paper, doi 10.1631/jzus.A0820373, repeated and judged: claims (of its text), page (with its figures)."""
