"""What all experiments share: cases, jobs that are done once and kept, sections of the report."""
