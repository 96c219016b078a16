"""What commands print: reports and tables on stdout, progress on stderr.

`report` and `table` are every command's, with the `progress_bar`. `cell_summary`, `summary_text` and
`stored_motion` are of ``apc inspect``, `checked_texts` of ``apc check``; `perceived_lines`,
`execution_report`, `trial_table` and `trials_output` say what was seen, executed and played.
"""
