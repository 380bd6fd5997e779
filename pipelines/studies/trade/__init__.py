"""Speed against accuracy: the same scene under many settings, what each costs, and how far it is from the truth."""
