"""What shows the answer to a machine: words, figures, and the sheet to sign."""
