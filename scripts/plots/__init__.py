"""The pictures of docs/benchmarks.md: documents.py reads rows, sheet.py has what all share, a file each family."""
