"""Why a QP has no solution, and what its limits cost the tasks: off the fast path, in numbers."""
