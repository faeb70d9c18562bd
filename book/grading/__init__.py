"""Hand out a chapter's exercises, and mark what comes back: `python -m book.grading`.

`assign` makes the sheet and the grader's key, `submissions` finds and reads what a student handed in, `student_run`
runs one student's notebook in a process of its own, of which `sandbox` is the program: it runs the answers and judges
them. `grade` does a round of this, and `gradebook` holds the course's rules and writes its tables and feedback.
"""
